"""Commands that read results: ``python -m study.report.commands check``, ``pages``, ....

``microimpact`` has ``claim``, ``compare`` and ``plan`` of them, by entry points. They end with 0 if
all is the same, 1 if something differs, and 2 on bad input.
"""

from __future__ import annotations

from pathlib import Path

import click

from microimpact.cli import run
from microimpact.cli.output import echo

REFERENCE = Path("tests/reference")
# Tables of a full run that the pages of the documentation read.
FULL = REFERENCE / "full"

_folder = click.Path(path_type=Path)
_reference_option = click.option(
    "--reference", type=_folder, default=REFERENCE, show_default=True, help="Committed references."
)


@click.command("check")
@click.argument("results", type=_folder)
@_reference_option
def check_command(results: Path, reference: Path) -> None:
    """Compare the tables, data and figures in RESULTS with committed references."""
    from study.report.check.differences import as_text
    from study.report.check.results import TABLE_FOLDERS, table_files
    from study.report.check.verify import require_same_settings, verify

    differences = verify(results, reference)
    require_same_settings(differences)
    if not differences:
        click.echo(f"{results}: {len(table_files(results))} files agree with {reference}")
        return
    click.echo(f"{results} differs from {reference}")
    for folder in TABLE_FOLDERS:
        names = {Path(d.file).stem for d in differences if d.file.startswith(f"{folder}/")}
        click.echo(f"{folder.capitalize()}: {', '.join(sorted(names)) or 'none'}")
    click.echo(f"\n{as_text(differences)}")
    raise SystemExit(1)


@click.command("reference")
@click.argument("results", type=_folder)
@_reference_option
@click.option("--remove", is_flag=True, help="Drop references of files that RESULTS lacks.")
def reference_command(results: Path, reference: Path, *, remove: bool) -> None:
    """Show how RESULTS differs from the references, then make it the reference."""
    from study.report.check.differences import as_text
    from study.report.check.verify import renew, verify

    reference.mkdir(parents=True, exist_ok=True)
    differences = verify(results, reference)
    if differences:
        click.echo(as_text(differences) + "\n")
    changed = renew(results, reference, differences, remove=remove)
    click.echo(f"{reference}: {len(changed)} files changed")


@click.command("compare", short_help="Two results folders side by side.")
@click.argument("baseline", type=_folder)
@click.argument("changed", type=_folder)
def compare_command(baseline: Path, changed: Path) -> None:
    """Compare inputs, numbers, verdicts and figures of two results folders."""
    from study.report.check.compare import compare

    changes = compare(baseline, changed)
    click.echo(f"# {baseline} (baseline) and {changed} (changed)\n\n{changes}")
    if not changes.same:
        raise SystemExit(1)


@click.command("claim", short_help="How a claim is judged.")
@click.argument("name")
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="KEY=VALUE",
    help="A declared value to change, as claim_numbers.steel.friction=0.3; may be repeated.",
)
@click.option(
    "--results",
    type=_folder,
    help="Folder of a run, whose tables are used if it has the shipped configuration; "
    "default: results, if it is there.",
)
def claim_command(name: str, settings: tuple[str, ...], results: Path | None) -> None:
    """Explain the claim NAME, such as C58: how it is judged, its numbers and their source.

    With --set the claim alone is computed; nothing is written.
    """
    from study.report.check.results import require_results
    from study.report.claim import changed, tell

    if results:
        require_results(results)
    echo(tell(name, changed(settings), results or Path("results")))


@click.command("plan", short_help="What an overlay would change.")
@click.argument("overlays", nargs=-1, required=True, type=_folder)
@click.option(
    "--results",
    type=_folder,
    default=Path("results"),
    show_default=True,
    help="Folder of a run as shipped.",
)
def plan_command(overlays: tuple[Path, ...], results: Path) -> None:
    """List the changes that OVERLAYS would make, before anything runs.

    These are the analyses, figures and claims that rest on a changed input. Nothing is written.
    """
    from study.report.plan import plan

    echo(plan(overlays, results))


@click.command("crate")
@click.argument("results", type=_folder)
def crate_command(results: Path) -> None:
    """Describe the run in RESULTS as a Workflow Run RO-Crate: RESULTS/ro-crate-metadata.json."""
    from study.report.crate import write_crate

    click.echo(f"Crate: {write_crate(results, Path())}")


@click.command("report")
@click.argument("results", type=_folder)
def report_command(results: Path) -> None:
    """Write the report of RESULTS anew, as pages for a browser: RESULTS/report/index.html."""
    from study.report.check.results import require_results
    from study.report.site.build import write_site
    from study.report.site.record import read_record

    require_results(results)
    pages = write_site(results, read_record(results))
    click.echo(f"{len(pages)} pages: {pages[0]}")


@click.command("pages")
@click.argument("results", type=_folder, default=FULL)
def pages_command(results: Path) -> None:
    """Write the pages of the documentation whose numbers come from RESULTS, a full run.

    Without RESULTS, the pages are written again from the tables that are kept.
    """
    from study.report.documents import renew

    changed = renew(results, Path("docs"), FULL)
    click.echo("\n".join(map(str, changed)) or "no page changes")


@click.group()
def commands() -> None:
    """Results of the study: checked, compared, described."""


for _command in (
    *(check_command, reference_command, compare_command, claim_command, plan_command),
    *(crate_command, report_command, pages_command),
):
    commands.add_command(_command)

if __name__ == "__main__":
    run(commands)
