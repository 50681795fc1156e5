"""The table of claims for the terminal, as CSV and as LaTeX."""

from __future__ import annotations

from collections import Counter
from typing import Any

from platform_daemon.core.reporting.tables import tables_text
from platform_daemon.features.characterise.side_by_side.tables import row_latex

from .claims import contradictions
from .schema import Claim, Claims


def claims_text(found: Claims) -> str:
    """The table, how many agree, and where the paper disagrees with itself."""
    rows = found.claims
    columns = (
        ("what", [c.what for c in rows]),
        ("paper", [_shown(c.paper) for c in rows]),
        ("ours", [_shown(c.ours) for c in rows]),
        ("tolerance", [_shown(c.tolerance, 2) for c in rows]),
        ("verdict", [str(c.verdict) for c in rows]),
    )
    table = tables_text("The paper's numbers", ("label", [c.label for c in rows]), columns)
    said = [f"the paper disagrees with itself: {text}" for text in contradictions()]
    return "\n".join([table, *said, count_text(found)])


def count_text(found: Claims) -> str:
    """How many of each verdict."""
    counted = Counter(claim.verdict for claim in found.claims)
    agree, differ, never = (counted[v] for v in ("agrees", "differs", "not_reproducible"))
    return f"{len(found.claims)} claims: {agree} agree, {differ} differ, {never} not reproducible"


def claim_rows(found: Claims) -> list[dict[str, Any]]:
    """For a CSV: a row per claim."""
    return [claim.model_dump() for claim in found.claims]


def claims_latex(found: Claims) -> str:
    """A longtable of all claims."""
    head = r"\begin{longtable}{llrrrl}" + "\n" + r"label & what & paper & ours & tolerance & verdict \\ \hline"
    rows = (row_latex([claim.label, *claim_cells(claim)]) for claim in found.claims)
    return "\n".join([head, *rows, r"\end{longtable}", ""])


def claim_cells(claim: Claim) -> tuple[str, str, str, str, str]:
    """What, paper, ours, tolerance, verdict, as they are read."""
    told = _shown(claim.paper), _shown(claim.ours), _shown(claim.tolerance, 2)
    return (claim.what, *told, claim.verdict.replace("_", " "))


def _shown(value: float | str | None, digits: int = 6) -> str:
    return "-" if value is None else value if isinstance(value, str) else f"{value:.{digits}g}"
