"""Ledger of equations: every relation of the article, proved by a check of its own.

``config/equations.yaml`` says what is printed and what is used; the proofs are here, by section.
Both forms are checked when the ledger is judged: the dimensions of all parts by Pint, and a proof
from first principles by SymPy, or by numbers. The verdict follows from these checks alone; only
where a slip comes from is declared.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import pandas as pd

from study.declared.parameters import build
from study.equations import (
    contact,
    empirical,
    energies,
    impulses,
    laboratory,
    motion,
    roughness,
)
from study.equations.case import reference_case
from study.equations.forms import (
    DECLARED,
    ERRATA,
    SYMBOLS,
    DimensionError,
    check_dimensions,
    parse,
)
from study.equations.records import At, Checked, Equation, Proof, ReferenceCase

EQUATIONS = {
    name: build(Equation, {"id": name, **entry})
    for name, entry in DECLARED.items()
    if name not in {SYMBOLS, ERRATA}
}
PROOFS: dict[str, Proof] = {
    **laboratory.PROOFS,
    **impulses.PROOFS,
    **energies.PROOFS,
    **contact.PROOFS,
    **motion.PROOFS,
    **empirical.PROOFS,
    **roughness.PROOFS,
}

# A formula and the function that implements it differ by rounding only.
AGREEMENT = 1e-9


class Checks(NamedTuple):
    """Outcomes of the checks of one form; `remark` names the disagreement in dimension."""

    dimension: Checked
    derivation: Checked
    remark: str = ""

    @property
    def hold(self) -> bool:
        """Whether nothing speaks against the form."""
        return self.dimension == "passed" and self.derivation != "failed"


def check(equation: Equation, proof: Proof, text: str, case: ReferenceCase) -> Checks:
    """Check the dimensions of a form, and prove it.

    Parameters
    ----------
    equation
        Whose symbols count.
    case
        The impact for numeric proofs.
    """
    derivation = proof.derivation.check(parse(text), case) if proof.derivation else "none"
    try:
        check_dimensions(text, equation.units)
    except DimensionError as error:
        return Checks("failed", derivation, str(error))
    return Checks("passed", derivation)


def agreement(equation: Equation, proof: Proof, case: ReferenceCase) -> float | None:
    """Return the relative difference between the used form and the function, if there is one."""
    if proof.computed is None:
        return None
    at = At(equation, case)
    formula, computed = at.used(), proof.computed(at.values())
    difference = abs(computed - formula)
    return difference / max(abs(formula), abs(computed)) if difference else 0.0


def verdict(equation: Equation, printed: Checks, used: Checks, apart: float | None) -> str:
    """Return the verdict that the checks of both forms give.

    ``definition``, ``correct``, ``typographical slip`` (of the scan), ``corrected`` (wrong as
    printed: an error of the article, or the scan does not tell), ``undecidable`` (the text leaves a
    choice open), or ``unproved``: the form used fails a check, or the function does not compute it.
    """
    if not used.hold or (apart is not None and apart > AGREEMENT):
        return "unproved"
    if not printed.hold:
        return "typographical slip" if equation.slip == "scan" else "corrected"
    return {"none": "definition", "open": "undecidable"}.get(printed.derivation, "correct")


def judge(tables: Mapping[str, pd.DataFrame]) -> dict[str, pd.DataFrame]:
    """Judge all relations.

    Parameters
    ----------
    tables
        ``materials`` and ``contacts``, declared rows of one pair, steel on silicon.

    Returns
    -------
    tables
        ``equations``, and as ``errata`` the slips of the article outside its equations, one row
        each.
    """
    case = reference_case(tables)
    rows = [row(equation, proof_of(equation), case) for equation in EQUATIONS.values()]
    return {"equations": pd.DataFrame(rows), "errata": pd.DataFrame(DECLARED[ERRATA])}


def proof_of(equation: Equation) -> Proof:
    """Return the proof of a relation; an empty one of a definition."""
    return PROOFS.get(equation.id, Proof())


def row(equation: Equation, proof: Proof, case: ReferenceCase) -> dict[str, Any]:
    """Return one judged relation."""
    printed = check(equation, proof, equation.printed, case)
    used = check(equation, proof, equation.used, case) if equation.used else printed
    apart = agreement(equation, proof, case)
    judged = verdict(equation, printed, used, apart)
    follows = proof.consequence
    return {
        "equation": equation.id,
        "section": equation.section,
        "printed": equation.printed,
        "used": equation.form_used,
        "dimension_printed": printed.dimension,
        "dimension_used": used.dimension,
        "derivation_printed": printed.derivation,
        "derivation_used": used.derivation,
        "verdict": judged,
        "kind_of_slip": equation.slip if judged in {"typographical slip", "corrected"} else "none",
        "error": (equation.error or equation.id) if equation.used else "",
        "reason": equation.reason,
        "function": equation.function,
        "consequence": equation.consequence,
        "consequence_value": follows(At(equation, case)) if follows else math.nan,
        "consequence_unit": equation.unit if follows else "",
        "evidence": _evidence(proof, printed, apart),
    }


def _evidence(proof: Proof, printed: Checks, apart: float | None) -> str:
    """Say how the row was checked."""
    parts = [proof.derivation.method if proof.derivation else "dimensions alone"]
    if printed.remark:
        parts.append(f"printed: {printed.remark}")
    if apart is not None:
        agrees = "agrees" if apart <= AGREEMENT else "disagrees"
        parts.append(f"function {agrees} within {AGREEMENT:g}")
    return "; ".join(parts)
