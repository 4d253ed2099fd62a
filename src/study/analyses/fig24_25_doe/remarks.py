"""Fig. 24: where the results agree with the article's description, and where they do not."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import Remark, stated

if TYPE_CHECKING:
    from study.figures.declaration import Stated
    from study.tables import ResultTables

DRAWN = {"variation": "realistic", "design": "fraction"}
CASES = "steel-silicon, n = 0", "steel-silicon, n = 1"


def exponent_decides_who_leads(tables: ResultTables) -> Stated:
    """With n = 0 C and D lead B clearly; with n = 1 the three are within a tenth."""
    (b0, c0, d0), (b1, c1, d1) = (
        [
            tables("doe_effects")(
                "effect_percent", case=case, response="v_c", effect=factor, **DRAWN
            )
            for factor in "BCD"
        ]
        for case in CASES
    )
    sizes = [abs(effect) for effect in (b1, c1, d1)]
    holds = min(abs(c0), d0) > 1.3 * b0 and max(sizes) < 1.1 * min(sizes)
    return stated(holds, b0=b0, c0=c0, d0=d0, low=min(sizes), high=max(sizes))


def fit_changes_little(tables: ResultTables) -> Stated:
    """No effect by the fit differs by more than a twentieth of the largest one."""
    exact, fitted = (
        tables("doe_effects").all("effect_percent", case=CASES[0], response=response, **DRAWN)
        for response in ("v_c", "v_c by Eq. 34")
    )
    most = max(abs(a - b) for a, b in zip(exact, fitted, strict=True))
    largest = max(map(abs, exact))
    return stated(0.0 < most < 0.05 * largest, most=most, largest=largest)


DISAGREEMENT = (
    Remark(
        "Which two factors stand out depends on the rate exponent of the adhesion damping. With "
        "n = 0 they are C, {c0:.0f} %, and D, {d0:.0f} %, not B, {b0:.0f} %; with n = 1 the "
        "three differ little in size, {low:.0f} to {high:.0f} %. The article has C and B.",
        exponent_decides_who_leads,
    ),
)
AGREEMENT = (
    Remark(
        "The article takes capture velocities from fits of Eq. 34. That changes no effect by "
        "more than {most:.1f} % of the mean, where the largest is {largest:.0f} %.",
        fit_changes_little,
    ),
)
