"""Figures as an analysis declares them: words, data and panels, beside their drawing.

Nothing here imports Matplotlib: the words are read at every start of the workflow.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from types import MappingProxyType
from typing import Any, Concatenate, Literal, ParamSpec, get_args

from microimpact.core.computable import NotComputable
from study import analyses
from study.declared import documents
from study.tables import Curves, ResultTables, TableError, Tables

Line = Literal["solid", "dashed", "dotted", "dashdot"]
Mark = Literal["circle", "square", "triangle"]

Format = Literal["svg", "png", "pdf"]
FORMATS: tuple[Format, ...] = get_args(Format)

# Words at the axes: one name, sign and unit of a quantity for all figures.
ANGLE = r"Angle of incidence $\alpha$ (°)"
RESTITUTION = "Coefficient of restitution $e$"
IMPULSE_RATIO = r"Impulse ratio $-\mu$"
MEASURED_RESTITUTION = "Measured restitution $e_m$"
MEASURED_IMPULSE_RATIO = r"Measured impulse ratio $-\mu_m$"
ENERGY_LOSS = "Energy loss $T_L$"
NORMAL_SPEED = "Normal impact speed $|v_n|$ (m/s)"
NOMINAL_SPEED = "Nominal impact speed (m/s)"
CAPTURE_VELOCITY = "Capture velocity $v_c$ (m/s)"
WORK_OF_ADHESION = "Work of adhesion $w_A$ (J/m$^2$)"

# The angle of incidence, from the surface, as abscissa of a panel.
OVER_ANGLE: dict[str, Any] = {
    "xlim": (0.0, 90.0),
    "xlabel": ANGLE,
    "xticks": (0, 15, 30, 45, 60, 75, 90),
}

# The origin of the single contacts of steel on silicon, said under many figures.
TWO_STAGES = (
    "The single contacts of steel on silicon are from the article's two-stage procedure "
    "(Section 3.2.1), by a restitution and the printed capture velocity."
)


@dataclass(frozen=True, slots=True)
class Series:
    """How one series is called in the legend and drawn; marks are solid unless `open`.

    Marks of virtual experiments have the shape `mark`, printed values are diamonds. A curve that
    has a place `beside` it, an abscissa, is named there and not in the legend, as is one whose
    label begins with an underscore. Of a `band` only the bounds are drawn. A `thin` curve is second
    to the one of its colour and dashes.
    """

    label: str
    colour: int | None = None
    line: Line = "solid"
    open: bool = False
    band: bool = False
    thin: bool = False
    beside: float | None = None
    mark: Mark = "circle"
    side: Literal["above", "below", "right", "left"] = "above"


# Laws of contact of steel on silicon: bands of posterior contacts, then the single contacts.
STEEL_LAWS = {
    "ring force, n free": Series("ring force, $n$ from 0 to 2", 0),
    "ring force, n = 0": Series("ring force, $n$ = 0", 2, line="dashed"),
    "JKR, viscous": Series("JKR, viscous", 1, line="dashdot"),
    "steel-silicon, n = 0": Series("two stages, $n$ = 0", 6, line="dotted"),
    "steel-silicon, n = 1": Series("two stages, $n$ = 1", 6, thin=True),
}

Draw = Callable[[Any], None]  # Of a `Sheet`
Words = ParamSpec("Words")
# What a finding states of the curves of its figure, by name; None if they do not bear it.
Stated = Mapping[str, float] | None
# Fields whose texts take parameters of the analysis.
TEXTS = ("title", "finding", "caption", "method", "panels", "tables", "evidence_labels")

# Every figure by its name, as the modules that draw them are imported.
FIGURES: dict[str, Figure] = {}


def stated(bears: Any, **numbers: float) -> Stated:
    """Return the numbers that a finding states if the data bear it, else None."""
    return numbers if bears else None


def borne(text: str, numbers: Callable[[], Stated]) -> str:
    """Return a text with the numbers that it states; empty where the data do not bear them."""
    try:
        stated_numbers = numbers()
    except (KeyError, TableError, NotComputable):
        return ""
    return "" if stated_numbers is None else text.format(**stated_numbers)


@dataclass(frozen=True, slots=True)
class Remark:
    """A sentence on the article's description of a figure, and its check on tables of a run.

    `holds` returns the numbers for the ``{places}`` of the text, or None if the tables do not bear
    it: the sentence is then not shown.
    """

    text: str
    holds: Callable[[ResultTables], Stated]

    def said(self, tables: ResultTables) -> str:
        """Return the sentence with its numbers, empty if the tables do not bear it."""
        text = borne(self.text, lambda: self.holds(tables))
        return re.sub(r"(?<=\d)%", " %", re.sub(r"(?<!\S)-(?=\d)", "−", text))


@dataclass(frozen=True, slots=True)
class Figure:
    """One figure: its words, the figure data it is drawn from, its panels, and its drawing.

    `figure` declares one, as a decorator of the function that draws it. ``[[name]]`` in any text
    is a parameter of the analysis, see `documents.filled`. `article` says what the article shows
    there; it is empty for a figure of our own. `equations` are those of the article that the figure
    shows or rests on, by their numbers in the ledger, separated by commas. `tables` are those of
    the analysis that belong beside the figure, each with a sentence on what it holds. `finding` is
    the message, in one sentence; `holds` checks it on the curves of the figure and returns the
    numbers for its ``{places}``, see `checked`. `caption` says what is drawn, `method` how it was
    computed. `disagreement` and `agreement` are with what the article says of its figure.
    `as_shipped` and `contact` (the origin of the single contacts), at the end of the method, hold
    for the shipped impacts alone. `panels` have a title each, by the name of their data, and stand
    in rows of `columns`, all side by side if not given; `views` show the data of another panel,
    enlarged. `evidence_labels` replace words of the key of evidence, as of what another paper
    printed.
    """

    draw: Draw
    name: str
    title: str
    caption: str
    panels: Mapping[str, str]
    _: KW_ONLY
    data: tuple[str, ...]
    equations: str = ""
    article: str = ""
    finding: str = ""
    holds: Callable[[Curves], Stated] | None = None
    method: str = ""
    disagreement: tuple[Remark, ...] = ()
    agreement: tuple[Remark, ...] = ()
    as_shipped: str = ""
    contact: str = ""
    tables: Mapping[str, str] = field(default_factory=dict)
    evidence_labels: Mapping[str, str] = field(default_factory=dict)
    width: Literal["single", "double"] = "double"
    height_mm: float = 80.0
    columns: int | None = None
    views: Mapping[str, str] = field(default_factory=dict)
    is_schematic: bool = False  # A drawing of parts, not a plot of one quantity over another

    def __post_init__(self) -> None:
        """Put texts of several lines into one."""
        for key in ("caption", "article", "finding", "method", "as_shipped", "contact"):
            object.__setattr__(self, key, " ".join(getattr(self, key).split()))

    @property
    def analysis(self) -> str:
        """Name of the analysis: the folder of the module that draws the figure."""
        return self.draw.__module__.split(".")[-2]

    @property
    def description(self) -> str:
        """Finding and caption, for somebody who cannot see the picture."""
        return f"{self.finding} {self.caption}".strip()

    def filled(
        self, values: Mapping[str, Any], pairs: documents.Pairs, *, changed: bool = False
    ) -> Figure:
        """Return the figure with parameters of its analysis in its words.

        Parameters
        ----------
        values
            Parameters of the analysis.
        pairs
            As in `documents.filled`.
        changed
            Whether it shows other impacts than as shipped: ``as_shipped`` and ``contact`` are then
            left out.

        Raises
        ------
        ConfigError
            If there is no parameter of a name.
        """
        shipped = [] if changed else [self.as_shipped, self.contact]
        held = replace(
            self,
            method=" ".join(filter(None, [self.method, *shipped])),
            as_shipped="",
            contact="",
        )
        texts = {key: getattr(held, key) for key in TEXTS}
        return replace(held, **documents.filled(texts, values, self.name, pairs))

    def checked(self, tables: Tables) -> Figure:
        """Return the figure with the numbers of its data in the finding, or without a finding.

        The finding goes if nothing checks it, if the data do not bear it, or if they lack a curve
        or a point that it is about.
        """
        holds, curves = self.holds, Curves(tables)
        finding = borne(self.finding, lambda: holds(curves)) if holds else ""
        return replace(self, finding=finding)

    def compared(self, tables: ResultTables) -> tuple[list[str], list[str]]:
        """Return where the figure disagrees with the article, and where it agrees."""
        parts = self.disagreement, self.agreement
        said = ([remark.said(tables) for remark in part] for part in parts)
        disagreement, agreement = (list(filter(None, each)) for each in said)
        return disagreement, agreement

    def with_texts(self, texts: Mapping[str, Any]) -> Figure:
        """Return the figure with other texts, as `entry` has them."""
        return replace(self, **{key: texts[key] for key in TEXTS}, as_shipped="", contact="")

    def entry(self) -> dict[str, Any]:
        """Return the words of the figure as plain values, without its drawing."""
        keys = (*TEXTS, "analysis", "data", "article", "width", "height_mm")
        return {
            **{key: getattr(self, key) for key in keys},
            "equations": list(filter(None, self.equations.split(", "))),
            "drawing": f"{self.draw.__module__}.{self.draw.__name__}",
        }


def _declaring(
    make: Callable[Concatenate[Draw, Words], Figure],
) -> Callable[Words, Callable[[Draw], Draw]]:
    def with_words(*words: Words.args, **more: Words.kwargs) -> Callable[[Draw], Draw]:
        def declared(draw: Draw) -> Draw:
            made = make(draw, *words, **more)
            FIGURES[made.name] = made
            return draw

        return declared

    return with_words


# Decorator that declares the figure that a function draws on a sheet, by the words of a `Figure`.
figure = _declaring(Figure)


@cache
def all_figures() -> MappingProxyType[str, Figure]:
    """Return all figures by name, those of the article first."""
    for home in analyses.homes().values():
        drawing = f"{home.removesuffix('.compute')}.draw"
        if home.endswith(".compute") and find_spec(drawing):
            import_module(drawing)
    ours = sorted(FIGURES, key=lambda name: (not re.fullmatch(r"fig\d\d", name), name))
    return MappingProxyType({name: FIGURES[name] for name in ours})
