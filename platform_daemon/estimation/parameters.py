"""The names of the published parameters and what is said of each: a value and its standard deviation."""

from __future__ import annotations

from dataclasses import dataclass

RODRIGUES = ("rodrigues_x", "rodrigues_y", "rodrigues_z")
"""Orientation of the resonator, e_u, e_v, e_w in world axes, as a Rodrigues vector."""

PARAMETER_NAMES: tuple[str, ...] = (
    "f_nat_hz",
    "m_r_am2",
    "lambda_per_s",
    "tf_over_i_rad_per_s2",
    "phi_max_rad",
    "psi_start_rad",
    *RODRIGUES,
)


@dataclass(frozen=True)
class Estimate:
    """A value and its standard deviation; std None: the value was fixed, not estimated."""

    value: float
    std: float | None
