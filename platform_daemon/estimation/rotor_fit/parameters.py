"""What a fit of the rigid rotor leaves free, and what is known of it beforehand."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from platform_daemon.estimation.physics.rigid_rotor.geometry import RotorGeometry
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.rigid_rotor
Defect = Literal["stator_tilt_rad", "bearing_tilt_rad", "lateral_displacement_m"]
Start = Literal["rest", "swing", "free"]
"""Of a shot: the drive finds the rotor at rest, or in the swing of the shot before; or nothing is known of the drive,
and the motion begins with the first sample in any state."""
DEFECTS: tuple[Defect, ...] = ("stator_tilt_rad", "bearing_tilt_rad", "lateral_displacement_m")
OFF_DRAWING = ("radius_off_m", "link_off_m")
"""By which a rotor may differ from its drawing."""
HELD_WITH_A_DEFECT = (
    "distance_m",
    "side_damping_per_s",
    "lean_damping_per_s",
    "damping_axis_to_thread",
    "creep_m_per_s",
    "creep_spin_rad_per_s",
    *OFF_DRAWING,
)
"""What belongs to a specimen as its defect does: fits with an adopted defect hold both."""
KNOWN_WITH_A_DEFECT = (*HELD_WITH_A_DEFECT, "creep_law", "contact_coupling", "friction_coefficient")
"""With what differs from shot to shot, where fits with an adopted defect begin."""
NEEDED_WITH_A_DEFECT = ("distance_m", "side_damping_per_s", "creep_m_per_s", "friction_coefficient")
"""Those of which reports of every version tell."""


@dataclass(frozen=True, kw_only=True)
class FreeParameter:
    """One free parameter of RotorValues.

    step: of the forward difference; sd: how well it is known beforehand, None: not at all; common: to all shots;
    logarithmic: it is positive, and step, sd and covariances are those of its logarithm; least: 0, or of a logarithmic
    one that may be as small as that, and whose steps are shares of it, because what it does goes with it and not with
    its logarithm.  What a short window hardly tells stays there within what is known of it.
    """

    name: str
    step: float
    sd: float | None = None
    common: bool = False
    logarithmic: bool = False
    least: float = 0.0

    @property
    def most_step(self) -> float:
        """By how much one step may move it."""
        if not self.logarithmic:
            return math.inf
        return LIMITS.most_step_share if self.least else LIMITS.most_step_ln

    def moved(self, value: float, step: float) -> float:
        """Its value after a step."""
        if not self.logarithmic:
            return value + step
        bounded = min(max(step, -self.most_step), self.most_step)
        if not self.least:
            return value * math.exp(bounded)
        return max(value * (1.0 + bounded), min(value, self.least))

    def apart(self, value: float, other: float) -> float:
        """The step from one value to another one, were it not bounded."""
        return other / value - 1.0 if self.least else self.off(value, other)

    def off(self, value: float, other: float) -> float:
        """How far they are apart, as sd and covariances count it."""
        return math.log(other / value) if self.logarithmic else other - value

    def per_step(self, value: float) -> float:
        """By how much the value moves over a small step: errors of the one over those of the other."""
        return value if self.logarithmic else 1.0


def free_parameters(geometry: RotorGeometry, defects: Iterable[Defect], start: Start) -> tuple[FreeParameter, ...]:
    """Of one shot; defects: that are free."""
    own = [
        FreeParameter(name="f_nat_hz", step=LIMITS.step_f_nat_hz),
        FreeParameter(name="m_r_am2", step=LIMITS.step_m_r_am2),
        *(FreeParameter(name=f"turn_{axis}_rad", step=LIMITS.step_rad) for axis in "uvw"),
    ]
    if start == "free":
        own += _free_start(geometry)
    else:
        own.append(FreeParameter(name="drive_size", step=LIMITS.step_rad, sd=LIMITS.drive_size_sd))
        own.append(FreeParameter(name="drive_delay_s", step=LIMITS.step_s, sd=LIMITS.drive_delay_sd_s))
    if start == "swing":
        own.append(FreeParameter(name="start_angle_rad", step=LIMITS.step_rad, sd=LIMITS.start_sd_rad))
        own.append(
            FreeParameter(
                name="start_speed_rad_per_s",
                step=LIMITS.step_speed_rad_per_s,
                sd=LIMITS.start_sd_rad * LIMITS.typical_rad_per_s,
            )
        )
    common = [
        FreeParameter(name="lambda_per_s", step=LIMITS.step_per_s, sd=LIMITS.damping_sd_per_s, common=True),
        *(
            FreeParameter(
                name=name, step=LIMITS.step_weak_ln, sd=LIMITS.side_damping_sd_ln, common=True, logarithmic=True
            )
            for name in ("side_damping_per_s", "lean_damping_per_s")
        ),
    ]
    common.append(
        FreeParameter(
            name="distance_m",
            step=LIMITS.step_m,
            sd=LIMITS.distance_sd_m,
            common=True,
        )
    )
    if geometry.bearing == "thread":
        name = "damping_axis_to_thread"
        common.append(FreeParameter(name=name, step=LIMITS.step_share, sd=LIMITS.damping_axis_sd, common=True))
    for name, sd in zip(OFF_DRAWING, (geometry.radius_sd_m, geometry.link_sd_m), strict=True):
        if sd > 0.0:
            common.append(FreeParameter(name=name, step=LIMITS.step_m, sd=sd, common=True))
    for defect in defects:
        step = LIMITS.step_m if defect == "lateral_displacement_m" else LIMITS.step_rad
        common.append(FreeParameter(name=defect, step=step, common=True))
    if geometry.bearing == "jewel":
        own.append(FreeParameter(name="tf_over_i_rad_per_s2", step=LIMITS.step_friction_rad_per_s2))
        # Friction differs from shot to shot by its contact or by its coefficient: neither is common to all.
        own.append(FreeParameter(name="friction_coefficient", step=LIMITS.step_rad, sd=LIMITS.friction_coefficient_sd))
        common += [
            FreeParameter(
                name="creep_m_per_s",
                step=LIMITS.step_ln,
                sd=LIMITS.creep_sd_ln,
                common=True,
                logarithmic=True,
                least=LIMITS.least_creep_m_per_s,
            ),
            FreeParameter(
                name="creep_spin_rad_per_s",
                step=LIMITS.step_weak_ln,
                sd=LIMITS.creep_spin_sd_ln,
                common=True,
                logarithmic=True,
            ),
        ]
    return (*own, *common)


def _free_start(geometry: RotorGeometry) -> list[FreeParameter]:
    """The swing, of which nothing is known, and the side modes, which are small."""
    sd, sd_per_s = LIMITS.start_side_sd, LIMITS.start_side_sd * LIMITS.typical_rad_per_s
    found = [
        FreeParameter(name="start_angle_rad", step=LIMITS.step_rad),
        FreeParameter(name="start_speed_rad_per_s", step=LIMITS.step_speed_rad_per_s),
    ]
    for axis in "uv":
        found += [
            FreeParameter(name=f"start_place_{axis}", step=LIMITS.step_rad, sd=sd),
            FreeParameter(name=f"start_place_{axis}_per_s", step=LIMITS.step_speed_rad_per_s, sd=sd_per_s),
            FreeParameter(name=f"start_lean_{axis}_rad", step=LIMITS.step_rad, sd=sd),
        ]
        if geometry.bearing == "thread":
            name = f"start_lean_{axis}_rad_per_s"
            found.append(FreeParameter(name=name, step=LIMITS.step_speed_rad_per_s, sd=sd_per_s))
    return found
