"""A verdict on every number of the paper, and where the paper disagrees with itself."""

from __future__ import annotations

import math

from platform_daemon.design.equations import (
    PAPER_JEWEL,
    PAPER_MAGNETS,
    PRINTED_FRICTION_TORQUE_NM,
    friction_coefficient_of,
)
from platform_daemon.estimation.physics.quality import decay_time_s, equivalent_quality_factor
from platform_daemon.estimation.physics.ring_down import RingDown

from .break_even import JEWEL_N50, break_even_text
from .findings import Findings, Value
from .paper import paper_numbers
from .paper_number import PaperNumber
from .schema import Claim, Claims, ClaimVerdict

_SIGMAS = 3.0  # of our own standard error, as of the paper's


_PRINTED_D30_S = 1.28  # ssec:primary_results
_JEWEL_D30 = {
    "f_nat_hz": 213.25,
    "m_r_am2": 12.028e-3,
    "lambda_per_s": 0.0978,
    "tf_over_i_rad_per_s2": 1324.0,
    "phi_max_rad": math.radians(53.0),
    "psi_start_rad": math.radians(219.2),
}  # tab:model_params_fit_result


def claims_of(found: Findings) -> Claims:
    """Every number of the paper, compared with the measured one."""
    return Claims(claims=tuple(_claim(number, found) for number in paper_numbers()))


def _claim(number: PaperNumber, found: Findings) -> Claim:
    ours = number.ours(found)
    if ours is None or number.never:
        return _told(number, ours, None, "not_reproducible", number.never or number.missing(found))
    if number.tolerance is None or isinstance(ours.value, str) or isinstance(number.paper, str):
        return _told(number, ours, None, "agrees" if ours.value == number.paper else "differs", number.rule)
    tolerance = math.hypot(number.tolerance, _SIGMAS * (ours.u or 0.0))
    why = number.rule + (", and three standard errors of ours, in quadrature" if ours.u else "")
    near = abs(ours.value - number.paper) <= tolerance
    return _told(number, ours, tolerance, "agrees" if near else "differs", why)


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
    short, long = _jewel(**JEWEL_N50), _jewel(**_JEWEL_D30)
    decay_s = decay_time_s(long)
    q = [
        equivalent_quality_factor(short, 0.24),
        equivalent_quality_factor(long, _PRINTED_D30_S),
        equivalent_quality_factor(long),
    ]
    return (
        f"eq:tf(phi), eq:TfoverI: 3/16 pi a mu F_m with the printed mu = {PAPER_JEWEL.friction_coefficient:g} is "
        f"{PAPER_JEWEL.friction_coefficient / mu:.3f} times the printed {1e9 * PRINTED_FRICTION_TORQUE_NM:.1f} nNm, "
        f"which follow with mu = {mu:.3f}",
        f"tab:quality_factors: eq:tilde-Q at the means of tab:model_params_fit_result gives {q[0]:.0f}, {q[1]:.0f} "
        f"and {q[2]:.0f} for N50, D30 and T to infinity, printed are 1327, 897 and 641; the D30 means decay "
        f"to 30 % in {decay_s:.2f} s, the text has {_PRINTED_D30_S:.2f} s",
        "phi_max of 53 deg: eq:dotvarphimax with psi_start = 219.2 deg does not lie on the orbit of amplitude phi_max, "
        f"whose energy there is that of {math.degrees(_peak_rad(_JEWEL_D30)):.2f} deg",
        *break_even_text(),
    )


def _jewel(**values: float) -> RingDown:
    return RingDown.from_parameters("jewel", values)


def _peak_rad(printed: dict[str, float]) -> float:
    """Amplitude of the orbit through phi = phi_max cos psi, phi' = -omega sqrt(2 - 2 cos phi_max) sin psi, rad."""
    phi, psi = printed["phi_max_rad"], printed["psi_start_rad"]
    energy = (1.0 - math.cos(phi)) * math.sin(psi) ** 2 + 1.0 - math.cos(phi * math.cos(psi))
    return math.acos(1.0 - energy)
