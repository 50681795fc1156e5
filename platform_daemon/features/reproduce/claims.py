"""A verdict on every number of the paper, and where the paper disagrees with itself."""

from __future__ import annotations

import math

from platform_daemon.design.equations import (
    PAPER_JEWEL,
    PAPER_MAGNETS,
    PRINTED_FRICTION_TORQUE_NM,
    friction_coefficient_of,
)

from .break_even import break_even_text
from .findings import Findings, Value
from .paper import paper_numbers
from .paper_number import PaperNumber
from .printed_means import PRINTED_D30_S, decay_of_the_means_s, peak_of_the_means_rad, quality_of_the_means
from .schema import Claim, Claims, ClaimVerdict

_SIGMAS = 3.0  # of our own standard error, as of the paper's


def claims_of(found: Findings) -> Claims:
    """Every number of the paper, compared with the measured one."""
    return Claims(claims=tuple(_claim(number, found) for number in paper_numbers()))


def _claim(number: PaperNumber, found: Findings) -> Claim:
    ours = number.ours(found)
    if ours is None or number.never:
        return _told(number, ours, None, "not_reproducible", number.never or number.missing(found))
    if number.tolerance is None or isinstance(ours.value, str) or isinstance(number.paper, str):
        if ours.value == number.paper:
            return _told(number, ours, None, "agrees", number.rule)
        return _told(number, ours, None, "differs", "; ".join(filter(None, (number.because(found, ours), number.rule))))
    tolerance = math.hypot(number.tolerance, _SIGMAS * (ours.u or 0.0))
    why = number.rule + (", and three standard errors of ours, in quadrature" if ours.u else "")
    off = ours.value - number.paper
    if abs(off) <= tolerance:
        return _told(number, ours, tolerance, "agrees", why)
    by = f"off by {off:+.3g}, {abs(off) / tolerance:.2g} times the tolerance"
    return _told(number, ours, tolerance, "differs", "; ".join(filter(None, (by, number.because(found, ours), why))))


def _told(number: PaperNumber, ours: Value | None, tolerance: float | None, verdict: ClaimVerdict, why: str) -> Claim:
    return Claim(
        label=number.label,
        what=number.what,
        paper=number.paper,
        ours=None if ours is None else ours.value,
        u=None if ours is None else ours.u,
        tolerance=tolerance,
        verdict=verdict,
        why=why,
        command=number.command,
    )


def contradictions() -> tuple[str, ...]:
    """Where the paper's own numbers do not follow from one another, each with the arithmetic."""
    mu = friction_coefficient_of(PRINTED_FRICTION_TORQUE_NM, PAPER_MAGNETS, PAPER_JEWEL)
    decay_s, q = decay_of_the_means_s(), quality_of_the_means()
    return (
        f"eq:tf(phi), eq:TfoverI: 3/16 pi a mu F_m with the printed mu = {PAPER_JEWEL.friction_coefficient:g} is "
        f"{PAPER_JEWEL.friction_coefficient / mu:.3f} times the printed {1e9 * PRINTED_FRICTION_TORQUE_NM:.1f} nNm, "
        f"which follow with mu = {mu:.3f}",
        f"tab:quality_factors: eq:tilde-Q at the means of tab:model_params_fit_result gives {q[0]:.0f}, {q[1]:.0f} "
        f"and {q[2]:.0f} for N50, D30 and T to infinity, printed are 1327, 897 and 641; the D30 means decay "
        f"to 30 % in {decay_s:.2f} s, the text has {PRINTED_D30_S:.2f} s",
        "phi_max of 53 deg: eq:dotvarphimax with psi_start = 219.2 deg does not lie on the orbit of amplitude phi_max, "
        f"whose energy there is that of {math.degrees(peak_of_the_means_rad()):.2f} deg",
        *break_even_text(),
    )
