"""The figure registry: the entries of ``config/figures.yaml``, checked."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError

from microimpact.core.nearest import nearest
from study.declared import documents
from study.declared.parameters import Ascending, Finite, Name, Positive, build, explain
from study.tables import RESULT_EVIDENCE

Range = Annotated[tuple[Finite, Finite], Ascending]
Place = Literal[
    "above",
    "upper left",
    "upper right",
    "center right",
    "lower left",
    "lower right",
    "lower center",
]
Line = Literal["solid", "dashed", "dotted", "dashdot", "long dashed", "dashdotdot", "loose dashed"]
Mark = Literal["circle", "square", "triangle"]

# Every figure is written in each of these.
FORMATS = ("svg", "png", "pdf")
# A figure of the article by its number, or one of our own.
FIGURE_NAME = r"^(fig\d\d|[a-z]+(_[a-z]+)*)$"
# What draws plain curves, bands and marks.
CURVES = "study.figures.models.curves"

# What stands at an axis, by the quantity: one name, sign and unit for all figures.
QUANTITIES = {
    "angle of incidence": r"Angle of incidence $\alpha$ (°)",
    "restitution": "Coefficient of restitution $e$",
    "impulse ratio": r"Impulse ratio $-\mu$",
    "energy loss": "Energy loss $T_L$",
    "normal impact speed": "Normal impact speed $|v_n|$ (m/s)",
    "nominal impact speed": "Nominal impact speed (m/s)",
    "capture velocity": "Capture velocity $v_c$ (m/s)",
    "work of adhesion": "Work of adhesion $w_A$ (J/m$^2$)",
    "measured restitution": "Measured restitution $e_m$",
    "measured impulse ratio": r"Measured impulse ratio $-\mu_m$",
    "mean measured restitution": "Mean measured restitution $e_m$",
    "mean impulse ratio": r"Mean impulse ratio $-\mu$",
}


AS_SHIPPED: Mapping[str, object] = {}


class RegistryError(ValueError):
    """A registry with problems: one line each, beginning with the dotted key."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SeriesSpec:
    """How one series is called in the legend and drawn; marks are solid unless `open`.

    Marks of virtual experiments have the shape `mark`, printed values are diamonds. A curve that
    has a place `beside` it, an abscissa, is named there and not in the legend. Of a `band` only the
    bounds are drawn.
    """

    label: Name
    line: Line = "solid"
    colour: Annotated[int, Field(ge=0, le=6)] | None = None
    open: bool = False
    band: bool = False
    beside: Finite | None = None
    mark: Mark = "circle"
    side: Literal["above", "below", "right"] = "above"

    def __post_init__(self) -> None:
        """Set the rate exponent in the name of a contact as a symbol."""
        object.__setattr__(self, "label", re.sub(r"(?<!\$)\bn = ", "$n$ = ", self.label))


@dataclass(frozen=True, slots=True, kw_only=True)
class PanelSpec:
    """Axes of one panel, which only a plot has, and its series in the order of the legend.

    `shows` names the panel of the data if it is not the one of the same name, as for an
    enlarged view. A legend `above` is over all panels, clear of every curve. Axes grow
    where data lie outside; the upright one does not if `fixed`: simulated values above it are
    written at its edge. A label may be one of `QUANTITIES`. Numbers stand at the ticks or, on a
    logarithmic scale, at the steps times powers of ten. At `level` a thin line runs across. Marks
    of one abscissa stand `apart` by this factor; a thin line guides the eye along `joined` ones.
    """

    x_range: Range
    y_range: Range
    x_label: str = ""
    y_label: str = ""
    title: str = ""
    x_scale: Literal["linear", "log"] = "linear"
    y_scale: Literal["linear", "log", "symlog"] = "linear"
    x_ticks: tuple[Finite, ...] = ()
    y_ticks: tuple[Finite, ...] = ()
    x_steps: tuple[Positive, ...] = ()
    y_steps: tuple[Positive, ...] = ()
    level: Finite | None = None
    legend: str = ""
    legend_place: Place = "above"
    shows: str = ""
    fixed: bool = False
    joined: bool = False
    apart: Positive = 1.0
    series: dict[str, SeriesSpec] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Put the words of a quantity at its axis; refuse a logarithm of zero or less."""
        for axis in "xy":
            label, ends = getattr(self, f"{axis}_label"), getattr(self, f"{axis}_range")
            object.__setattr__(self, f"{axis}_label", QUANTITIES.get(label, label))
            is_log = getattr(self, f"{axis}_scale") == "log"
            if is_log and ends[0] <= 0.0:
                raise ValueError(f"{axis}_range: {ends[0]:g} must be above 0 on a log scale")
            if getattr(self, f"{axis}_steps") and not is_log:
                raise ValueError(f"{axis}_steps: must be empty: the scale is linear")


@dataclass(frozen=True, slots=True, kw_only=True)
class FigureSpec:
    """One figure: words, study and data it is drawn from, code that draws it, panels.

    `article` says what the article shows there; it is empty for a figure of our own. `equations`
    are those of the article that the figure shows or rests on, by their numbers in the ledger.
    `tables` are those of the study that belong beside the figure, each with a sentence on what it
    holds. `finding` is the message, in one sentence, `caption` says what is drawn, `method` how it
    was computed. The finding, and `as_shipped` and `contact` (the origin of the single contacts) at
    the end of the method, hold for the shipped inputs alone, see `filled`. Panels stand in rows of
    `columns`, all side by side if not given. `evidence_labels` replace words of the key of
    evidence, as of what another paper printed.
    """

    name: Annotated[str, Field(pattern=FIGURE_NAME)]
    title: Name
    caption: Name
    module: Annotated[str, Field(pattern=r"^study\.figures\.\w+\.\w+$")] = CURVES
    function: Name = "draw"
    study: Name
    equations: tuple[Name, ...] = ()
    data: Annotated[tuple[Name, ...], Field(min_length=1)]
    article: str = ""
    finding: str = ""
    method: str = ""
    as_shipped: str = ""
    contact: str = ""
    tables: dict[str, Name] = field(default_factory=dict)
    evidence_labels: dict[str, Name] = field(default_factory=dict)
    width: Literal["single", "double"] = "double"
    height_mm: Annotated[float, Field(gt=0, le=240)] = 80.0
    columns: Annotated[int, Field(ge=1)] | None = None
    panels: dict[str, PanelSpec]

    def __post_init__(self) -> None:
        """Refuse an unnamed axis, and words for evidence or axes that there are not."""
        for name in self.evidence_labels:
            if name not in RESULT_EVIDENCE:
                near = nearest(name, RESULT_EVIDENCE)
                raise ValueError(f"evidence_labels: {name!r} is no evidence of results{near}")
        for name, panel in self.panels.items():
            for axis in ("x", "y"):
                if bool(label := getattr(panel, f"{axis}_label")) == self.is_schematic:
                    must = "must be empty: it has no axes" if label else "must not be empty"
                    raise ValueError(f"panels.{name}.{axis}_label: {label!r} {must}")

    @property
    def is_schematic(self) -> bool:
        """Whether the figure is a drawing of parts, not a plot of one quantity over another."""
        return ".schematics." in self.module


def figure_spec(name: str, entry: object) -> FigureSpec:
    """Return the entry of one figure.

    Raises RegistryError, naming the dotted key of every problem, one line each.
    """
    if not isinstance(entry, Mapping):
        raise RegistryError(f"{name}: {entry!r} must be a mapping")
    try:
        return build(FigureSpec, {"name": name, **entry})
    except ValidationError as error:
        raise RegistryError("\n".join(explain(error, FigureSpec, name))) from None


def registry(entries: Mapping[str, Mapping[str, Any]]) -> dict[str, FigureSpec]:
    """Return all figures of a registry, in order of their names.

    Raises RegistryError, naming the dotted key of every problem in any figure, one line each.
    """
    specs, problems = {}, []
    for name in sorted(entries, key=_order):
        try:
            specs[name] = figure_spec(name, entries[name])
        except RegistryError as error:
            problems.append(str(error))
    if problems:
        raise RegistryError("\n".join(problems))
    return specs


def filled(
    entries: Mapping[str, Any],
    branches: Mapping[str, Mapping[str, Any]],
    pairs: documents.Pairs = documents.NO_PAIRS,
    changed: Mapping[str, object] = AS_SHIPPED,
) -> dict[str, Any]:
    """Put values of each figure's study into its words.

    Parameters
    ----------
    entries
        Of the registry, by figure.
    branches
        Parameters of the studies.
    pairs
        As in `documents.filled`.
    changed
        By study, inputs on which it rests and that are not as shipped. If there are any, the
        sentences ``finding``, ``as_shipped`` and ``contact`` are left out.

    Raises
    ------
    RegistryError
        If a study is not known.
    ConfigError
        If it has no such parameter.
    """
    result = {}
    for name, entry in entries.items():
        study = entry.get("study") if isinstance(entry, Mapping) else None
        if study is not None and (not isinstance(study, str) or study not in branches):
            raise RegistryError(f"{name}.study: {study!r} is no study{nearest(study, branches)}")
        values = branches[study] if study else {}
        held = _as_it_holds(entry, changed.get(str(study)))
        result[name] = documents.filled(held, values, name, pairs)
    return result


def _as_it_holds(entry: Any, changed: object) -> Any:
    """Return an entry with the sentences of shipped inputs after its method, or without."""
    if not isinstance(entry, Mapping):
        return entry
    shipped = dict.fromkeys(("as_shipped", "contact"), "")
    if changed:
        return {**entry, "finding": "", **shipped}
    sentences = (entry.get(key, "") for key in ("method", *shipped))
    return {**entry, "method": " ".join(filter(None, sentences)), **shipped}


def _order(name: object) -> tuple[int, str]:
    """Order the article's figures by number, and ours after them by name."""
    digits = re.findall(r"\d+", str(name))
    return (int(digits[0]) if digits else 1000, str(name))
