"""Slips of the article outside its equations: words, labels and citations that mislead a reader."""

from __future__ import annotations

import pandas as pd

COLUMNS = ("where", "kind", "printed", "meant", "reason")

ERRATA = (
    (
        "2.4.1, Figs. 6, 7",
        "word",
        "incident normal velocity of 1.66 m/s",
        "incident speed of 1.66 m/s",
        "Spheres fall on a turned surface from one height (3.1.4): the speed is the same at all "
        "angles, its normal component is not.",
    ),
    (
        "3.2, Fig. 19",
        "word",
        "hemispherical compressive stress",
        "semi-ellipsoidal",
        "The pressure of Hertz is p_0 sqrt(1 - (x/a)^2), half an ellipse over the contact.",
    ),
    (
        "2",
        "citation",
        "Wall et al. [13]",
        "[3]",
        "[13] is by Buttle, Martin and Scruby, and is cited so in 2.4.",
    ),
    (
        "2.4, 3.2.2",
        "citation",
        "Dunn et al. [5], on oblique impact",
        "[14]",
        "[5] is by Li, Dunn and Brach, and about normal impact.",
    ),
    (
        "3.1.3, on Fig. 15",
        "citation",
        "measurements [19]",
        "[3] and [8]",
        "[19] is a seminar on a model; the caption names the two measurements.",
    ),
    (
        "2.4.2",
        "label",
        "SST6",
        "SST65",
        "The spheres of this section and of Figs. 8 to 10 are of the class SST65.",
    ),
    (
        "4.2",
        "label",
        "SST70",
        "SST76",
        "No class SST70 is described; the data are those of Fig. 12, taken with SST76.",
    ),
)


def errata() -> pd.DataFrame:
    """Return the slips, one row each."""
    return pd.DataFrame(ERRATA, columns=COLUMNS)
