"""Fig. 20: where the results agree with the article's description, and where they do not."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import Remark, stated

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.tables import ResultTables


def small_forces_take_energy(tables: ResultTables) -> Stated:
    """Damping is below a tenth of the Hertz force, but takes over a fifth of the energy."""
    adhesion, damping, e = (
        tables("force_ratios")("value", quantity=name)
        for name in (
            "peak_adhesion_over_peak_hertz",
            "peak_adhesion_dissipation_over_adhesion",
            "coefficient_of_restitution",
        )
    )
    share, loss = adhesion * damping, 1.0 - e**2
    return stated(share < 0.1 and loss > 0.2, share=share, loss=loss)


AGREEMENT = (
    Remark(
        "The dissipative force is small, as the article notes: at most {share:.0%} of the "
        "largest Hertz force. It nevertheless takes {loss:.0%} of the energy.",
        small_forces_take_energy,
    ),
)
