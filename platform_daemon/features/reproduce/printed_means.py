"""What follows from the printed means of the jewel (tab:model_params_fit_result)."""

from __future__ import annotations

import math
from functools import cache

from platform_daemon.estimation.physics.quality import decay_time_s, equivalent_quality_factor
from platform_daemon.estimation.physics.ring_down import RingDown

from .break_even import JEWEL_N50

PRINTED_D30_S = 1.28
"""Length of the jewel's D30, ssec:primary_results."""
_JEWEL_D30 = {
    "f_nat_hz": 213.25,
    "m_r_am2": 12.028e-3,
    "lambda_per_s": 0.0978,
    "tf_over_i_rad_per_s2": 1324.0,
    "phi_max_rad": math.radians(53.0),
    "psi_start_rad": math.radians(219.2),
}


@cache
def quality_of_the_means() -> tuple[float, float, float]:
    """Equivalent Q (eq:tilde-Q) over N50, over D30, and until the motion has died."""
    short, long = _jewel(JEWEL_N50), _jewel(_JEWEL_D30)
    return (
        equivalent_quality_factor(short, 0.24),
        equivalent_quality_factor(long, PRINTED_D30_S),
        equivalent_quality_factor(long),
    )


def decay_of_the_means_s() -> float:
    """Until 30 % of the signal is left, by the means of D30, s."""
    return decay_time_s(_jewel(_JEWEL_D30))


def peak_of_the_means_rad() -> float:
    """Amplitude of the orbit through phi = phi_max cos psi, phi' = -omega sqrt(2 - 2 cos phi_max) sin psi, rad."""
    phi, psi = _JEWEL_D30["phi_max_rad"], _JEWEL_D30["psi_start_rad"]
    energy = (1.0 - math.cos(phi)) * math.sin(psi) ** 2 + 1.0 - math.cos(phi * math.cos(psi))
    return math.acos(1.0 - energy)


def _jewel(values: dict[str, float]) -> RingDown:
    return RingDown.from_parameters("jewel", values)
