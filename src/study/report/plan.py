"""Changes that an overlay would make to inputs, analyses, figures and claims."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path
from textwrap import fill

from study import analyses
from study.declared.documents import load
from study.declared.references import merged
from study.figures.declaration import all_figures
from study.judge.changed import OF_ANOTHER, with_inputs
from study.run.changed import changed_inputs
from study.run.config import validate
from study.run.study import settings_as_shipped, shipped_configuration
from study.tables import text_rows

# Rules that are run again after any analysis.
AFTER = ("claim_draws", "claims", "report")


def plan(overlays: Sequence[Path], results: Path) -> str:
    """Return inputs, analyses, figures and claims that differ from the shipped study.

    Parameters
    ----------
    overlays
        Files of changed keys, the later merged over the earlier.
    results
        Folder of a run as shipped, for the claims and the seconds.

    Raises
    ------
    ConfigError
        If a file cannot be read, or a key is unknown or its value not allowed.
    """
    config = shipped = shipped_configuration()
    for path in overlays:
        config = merged(config, load(path))
    settings = validate(config, shipped)
    changed = changed_inputs(settings, settings_as_shipped())
    made = [name for name, inputs in changed.items() if inputs]
    left_out = settings.general.figures.leave_out
    drawn = {name: figure for name, figure in all_figures().items() if name not in left_out}
    figures = [name for name, figure in drawn.items() if figure.analysis in made]
    places = dict.fromkeys(place for name in made for place in changed[name].values())
    lines = [
        _listed("Inputs that differ", places),
        _listed(f"Of {len(analyses.homes())} analyses, made anew", made),
        _listed(f"Of {len(drawn)} figures, drawn anew", figures),
    ]
    if not (results / "tables/claims.csv").is_file():
        return "\n".join([*lines, f"Claims and seconds are known after a run: none in {results}."])
    verdicts = defaultdict[str, list[str]](list)
    for row in text_rows(results / "tables/claims.csv"):
        after = with_inputs(row, changed)
        if after["changed_inputs"]:
            is_lost = after["verdict"] == OF_ANOTHER != row["verdict"]
            verdicts[OF_ANOTHER if is_lost else "judged anew"].append(row["id"])
    lines += [_listed(f"Claims {kind}", names) for kind, names in sorted(verdicts.items())]
    costs = {path.stem: _seconds(path) for path in (results / "benchmarks").glob("*.tsv")}
    anew = {*made, *(f"{name}_figures" for name in made), *(AFTER if made else ())}
    spent = sum(seconds for rule, seconds in costs.items() if rule in anew)
    lines.append(f"These took {spent:.0f} of the {sum(costs.values()):.0f} s of all jobs there.")
    return "\n".join(lines)


def _listed(what: str, names: Iterable[str]) -> str:
    names = list(names)
    return fill(
        f"{what}, {len(names)}: {', '.join(names) or '-'}",
        subsequent_indent="  ",
        break_on_hyphens=False,
    )


def _seconds(path: Path) -> float:
    """Return the duration of a job, from its benchmark."""
    return float(path.read_text(encoding="utf-8").splitlines()[1].split("\t")[0])
