"""Figure separation: forces on a charged particle against the silica on it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from study.figures.declaration import Series, figure, stated

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.figures.style import Sheet
    from study.tables import Curves


def adhesion_falls_below_patches(y: Curves) -> Stated:
    """Adhesion, falling, crosses the attraction of patches within the weights drawn."""
    excess = (y("adhesion") / y("charged patches")).map(math.log)
    crosses = excess.iloc[0] > 0.0 > excess.iloc[-1] and excess.is_monotonic_decreasing
    return stated(crosses, crossing=float(np.interp(0.0, -excess, excess.index)))


@figure(
    "separation",
    "Separation force of a charged particle against the silica on it",
    """
        Forces that hold an irregular particle of [[diameter_um:g]] µm on a plane, against the
        weight of silica on it: JKR adhesion, and the image attraction of a uniform charge and of
        charged patches. Lines: geometric middles of the declared ranges; bands: all combinations
        of low, middle and high. Marks: printed by Rimai et al. 2000.
    """,
    {"forces": ""},
    data=("separation",),
    finding="""
        From {crossing:.1f} % of nanometre silica on, the adhesion of a particle is less
        than the attraction of charged patches on it.
    """,
    holds=adhesion_falls_below_patches,
    method="""
        Beyond the article: the contribution that the same issue of the journal opens with. The
        adhesion is that of the bare contact and of the spherules that carry the rest, with the
        silica side by side; dash-dotted and thin are the limits at the middles for silica that falls
        at random and may overlap, and for three spherules that lift the whole contact. The
        patches are as dense as breakdown allows. Marks: what the abstract of Rimai, Quesnel and
        Reifenberger (J. Adhesion 74, 2000) states, JKR's force without silica and about 5 % of
        it at [[compared_silica_fraction:.0%]], on the JKR force of this figure; their bars are
        the range of that force.
    """,
    tables={
        "particle_separation": "Forces at the middles and over the ranges, and which sentences of the abstract hold.",
    },
    evidence_labels={
        "printed": "printed by Rimai et al. 2000, not in the article",
    },
    height_mm=86.0,
)
def draw_separation(sheet: Sheet) -> None:
    """Adhesion, and attraction of charges, against the weight of silica."""
    silica = "Silica on the particle (% of weight)"
    forces = {
        "adhesion": Series("adhesion (JKR), middle and range", 0),
        "adhesion, random": Series("limit: silica at random", 0, line="dashdot"),
        "adhesion, lifted": Series("limit: lifted by three", 0, thin=True),
        "stated": Series("abstract, Rimai et al. 2000", 6),
        "charged patches": Series("charged patches, middle and range", 1, line="dotted"),
        "uniform charge": Series("uniform charge, middle and range", 2, line="dashed"),
    }
    (ax,) = sheet.panels(yscale="log", xlabel=silica, ylabel="Force (nN)")
    ax.set(xlim=(-0.1, 3.0), ylim=(0.8, 3000.0))
    sheet.draw(ax, forces)
    sheet.keys()
