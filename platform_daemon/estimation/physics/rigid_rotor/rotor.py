"""The rigid rotor by named parameters: geometry, manufacturing errors, drive, and the dm/dt that follows."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.rotation import rotation_from_rodrigues
from platform_daemon.estimation.thresholds import THRESHOLDS

from .equations import (
    ANCHOR,
    AXIS,
    CONTACT_COUPLING,
    CREEP,
    CREEP_LAW,
    CREEP_SPIN,
    DAMPING,
    DAMPING_AXIS,
    DRIVE_SLOTS,
    END,
    FIELD,
    FRICTION,
    HERTZ,
    INERTIA,
    JEWEL,
    LAG,
    LANES,
    LEAN_DAMPING,
    LINK,
    MASS,
    MOMENT,
    MOMENT_SIZE,
    OMEGA,
    PERMEABILITY,
    PHASE,
    PULSATION,
    RADIUS,
    SIDE_DAMPING,
    SLOTS,
    SPIN_LEVER,
    STATES,
    STATOR,
    STATOR_MOMENT,
    USUAL_LOAD_ROOT,
    WEIGHT,
)
from .geometry import RotorGeometry
from .motions import motions_beside
from .swing import accelerations, padded

LIMITS = THRESHOLDS.rigid_rotor
DOWN_M_PER_S2 = (0.0, 0.0, -9.81)  # world axes
STARTS = (
    "start_angle_rad",
    "start_speed_rad_per_s",
    "start_place_u",
    "start_place_v",
    "start_place_u_per_s",
    "start_place_v_per_s",
    "start_lean_u_rad",
    "start_lean_v_rad",
    "start_lean_u_rad_per_s",
    "start_lean_v_rad_per_s",
)
"""Of RotorValues, the state in which the drive finds the rotor."""


class NoRestError(ValueError):
    """The rotor has no position of rest near the main axis."""


class LostRotorError(ValueError):
    """The motion cannot be followed: the parameters are far from any rotor."""


@dataclass(frozen=True, kw_only=True)
class CoilDrive:
    """What the coils play from rest on, as the recording states it.

    field_t: (3,) peak in world axes; phase_rad: of the field's sine at its start, t = 0; rx_start_s: of the first RX
    sample; lag_s: L/R of the coils, by which the field begins and ends.
    """

    field_t: tuple[float, float, float]
    frequency_hz: float
    phase_rad: float
    duration_s: float
    rx_start_s: float
    lag_s: float = LIMITS.drive_lag_s


NO_DRIVE = CoilDrive(field_t=(0.0, 0.0, 0.0), frequency_hz=0.0, phase_rad=0.0, duration_s=0.0, rx_start_s=0.0)
"""A motion that begins with its first sample."""


@dataclass(frozen=True, kw_only=True)
class RotorValues:
    """All parameters of one shot in SI.

    f_nat_hz: of the magnets without manufacturing errors (eq:omega_nat); distance_m: of the magnets' centres, which the
    temperature does not change, as it does their moments; tf_over_i_rad_per_s2: dry friction of a
    jewel's contact when it only spins, undeflected; lambda_per_s: damps the turning about the main axis, which is the
    rotor's own or, by a share damping_axis_to_thread, the thread's; side_damping_per_s: damps its centre's motion,
    lean_damping_per_s its turning about the other axes; creep_m_per_s, creep_spin_rad_per_s: slip and spin below
    which the contact creeps; creep_law: 0, the friction falls there as s / sqrt(s^2 + c^2), 1, as s / (s + c), 2, as 0
    at each point of the disc, whose spin needs no number of its own, 3, Coulomb's law at each point of the disc, where
    slip and spin creep as with 0, 4, the same with the tangent tanh(s / c), where s is the root of the squares of slip
    and of the disc's edge, or of slip and spin, each with its own, where they do not share the friction;
    contact_coupling: 1, slip and spin share the friction of one disc, 0, each has its own; tilts and displacement as in
    fig:math_description_angle_defects (about v, along u), bearing_tilt_rad being the rotor's moment against the thread
    or the jewel about its first contact; rotation: (3, 3), from u, v, w to world axes; turn_*_rad: rotation vector by
    which it is turned, in u, v, w; drive_size: times the stated field; drive_delay_s: of the samples; start_angle_rad,
    start_speed_rad_per_s: of the swing at the start of the drive; start_place_*, start_lean_*: of the side modes there,
    the held point's displacement over its link along u and v, and the rotation of the rotor about u and v, each from
    rest, with their rates; a jewel rolls, so that its place tells the rate of its lean; radius_off_m, link_off_m: by
    which the drawing is too small.
    """

    f_nat_hz: float
    m_r_am2: float
    lambda_per_s: float
    rotation: Array
    distance_m: float
    tf_over_i_rad_per_s2: float = 0.0
    friction_coefficient: float = 0.0
    side_damping_per_s: float = 0.0
    lean_damping_per_s: float = 0.0
    damping_axis_to_thread: float = 0.0
    creep_m_per_s: float = 0.0
    creep_spin_rad_per_s: float = 0.0
    creep_law: float = 0.0
    contact_coupling: float = 1.0
    stator_tilt_rad: float = 0.0
    bearing_tilt_rad: float = 0.0
    lateral_displacement_m: float = 0.0
    turn_u_rad: float = 0.0
    turn_v_rad: float = 0.0
    turn_w_rad: float = 0.0
    drive_size: float = 1.0
    drive_delay_s: float = 0.0
    start_angle_rad: float = 0.0
    start_speed_rad_per_s: float = 0.0
    start_place_u: float = 0.0
    start_place_v: float = 0.0
    start_place_u_per_s: float = 0.0
    start_place_v_per_s: float = 0.0
    start_lean_u_rad: float = 0.0
    start_lean_v_rad: float = 0.0
    start_lean_u_rad_per_s: float = 0.0
    start_lean_v_rad_per_s: float = 0.0
    radius_off_m: float = 0.0
    link_off_m: float = 0.0

    @property
    def start(self) -> dict[str, float]:
        """In which the drive finds the rotor, by name."""
        return {name: getattr(self, name) for name in STARTS}

    def with_numbers(self, numbers: Mapping[str, float]) -> RotorValues:
        """The same with other numbers, by name."""
        changes: dict[str, Any] = dict(numbers)
        return replace(self, **changes)


@dataclass(frozen=True)
class RigidRotor:
    """One shot of a rotor: its motion from rest through the drive, and the dm/dt that follows.

    drawing: from which the values may tell that the rotor differs; gravity_m_per_s2: world axes.
    """

    drawing: RotorGeometry
    values: RotorValues
    drive: CoilDrive
    gravity_m_per_s2: tuple[float, float, float] = DOWN_M_PER_S2

    @cached_property
    def geometry(self) -> RotorGeometry:
        """The drawing with what the values tell to be off."""
        return self.drawing.resized(self.values.radius_off_m, self.values.link_off_m)

    @cached_property
    def rotation(self) -> Array:
        """(3, 3), from u, v, w to world axes."""
        v = self.values
        turned = rotation_from_rodrigues(np.array([v.turn_u_rad, v.turn_v_rad, v.turn_w_rad]))
        return np.asarray(v.rotation @ turned)

    @property
    def omega_rad_per_s(self) -> float:
        """omega_nat."""
        return 2.0 * math.pi * self.values.f_nat_hz

    @property
    def stator_moment_am2(self) -> float:
        """Of the stator, which gives f_nat with m_r at this distance (eq:T_m, eq:omega_nat)."""
        field_t = self.geometry.inertia_kg_m2 * self.omega_rad_per_s**2 / self.values.m_r_am2
        return float(field_t * self.values.distance_m**3 / PERMEABILITY)

    @property
    def contact_radius_m(self) -> float:
        """Of the pressure circle at rest, that T_f/I and mu imply (eq:tf); 0 without friction."""
        v = self.values
        if v.tf_over_i_rad_per_s2 == 0.0 or v.friction_coefficient == 0.0:
            return 0.0
        torque = v.tf_over_i_rad_per_s2 * self.geometry.inertia_kg_m2
        return torque / (SPIN_LEVER * v.friction_coefficient * self._pull_n)

    @property
    def sticks(self) -> bool:
        """Its contact takes slip back faster than explicit steps can follow cheaply, see `implicit_step`.

        It does so where it hardly spins, at the turning points, and all the time where the swing is small.
        """
        return self.values.creep_m_per_s < self._creep_at(LIMITS.sticking_per_s)

    @property
    def least_quiet_creep_m_per_s(self) -> float:
        """Slip from which on its contact has to creep for neighbours to differ by no noise; 0 for a thread.

        Explicit steps make noise where their limit of stability chooses them, implicit ones at each change of sign.
        """
        return self._creep_at(LIMITS.quiet_per_s)

    def _creep_at(self, rate_per_s: float) -> float:
        """Slip below which its contact creeps if it takes slip back at a rate."""
        g = self.geometry
        if g.bearing != "jewel":
            return 0.0
        lightness = 1.0 / g.mass_kg + g.radius_m**2 / g.inertia_kg_m2
        return self.values.friction_coefficient * self._pull_n * lightness / rate_per_s

    @property
    def _pull_n(self) -> float:
        return self.geometry.pull_n(self.values.f_nat_hz, self.values.distance_m)

    @cached_property
    def parameters(self) -> Array:
        """Of the kernels, (SLOTS,), see `equations`."""
        g, v, d = self.geometry, self.values, self.values.distance_m
        p = np.zeros(SLOTS)
        p[JEWEL] = float(g.bearing == "jewel")
        p[MASS], p[INERTIA], p[LINK], p[RADIUS] = g.mass_kg, g.inertia_kg_m2, g.link_m, g.radius_m
        p[ANCHOR + 2] = d + g.link_m + g.radius_m
        if p[JEWEL]:
            cup = g.link_m + g.radius_m
            contact = d - g.radius_m
            p[ANCHOR], p[ANCHOR + 2] = cup * math.sin(v.bearing_tilt_rad), contact + cup * math.cos(v.bearing_tilt_rad)
        p[STATOR] = v.lateral_displacement_m
        p[STATOR_MOMENT] = -self.stator_moment_am2 * math.cos(v.stator_tilt_rad)
        p[STATOR_MOMENT + 2] = self.stator_moment_am2 * math.sin(v.stator_tilt_rad)
        p[MOMENT_SIZE] = v.m_r_am2
        p[WEIGHT : WEIGHT + 3] = g.mass_kg * self.rotation.T @ np.array(self.gravity_m_per_s2)
        p[DAMPING], p[SIDE_DAMPING] = v.lambda_per_s, v.side_damping_per_s
        p[FRICTION] = v.friction_coefficient
        p[USUAL_LOAD_ROOT] = self._pull_n ** (1.0 / 3.0)
        p[HERTZ] = self.contact_radius_m / p[USUAL_LOAD_ROOT]
        p[LEAN_DAMPING], p[DAMPING_AXIS] = v.lean_damping_per_s, v.damping_axis_to_thread
        p[CREEP], p[CREEP_SPIN] = v.creep_m_per_s, v.creep_spin_rad_per_s
        p[CREEP_LAW], p[CONTACT_COUPLING] = v.creep_law, v.contact_coupling
        return p

    @cached_property
    def coils(self) -> Array:
        """The drive for the kernels, (DRIVE_SLOTS,)."""
        out = np.zeros(DRIVE_SLOTS)
        v, d = self.values, self.drive
        out[FIELD : FIELD + 3] = v.drive_size * (self.rotation.T @ np.array(d.field_t))
        out[PULSATION] = 2.0 * math.pi * d.frequency_hz
        out[PHASE], out[LAG], out[END] = d.phase_rad, d.lag_s, d.duration_s
        return out

    def rest(self) -> Array:
        """The state (STATES,) of equilibrium without friction.  Raises NoRestError."""
        radius_m, link_m = self.geometry.radius_m, self.geometry.link_m
        if not (self.values.distance_m > radius_m > 0.0 and link_m > 0.0 and self.values.m_r_am2 > 0.0):
            magnets = f"magnets {self.values.distance_m:.3g} m apart with {self.values.m_r_am2:.3g} A m^2"
            raise NoRestError(f"{magnets}, a radius of {radius_m:.3g} m and a link of {link_m:.3g} m")
        p = self.parameters.copy()
        p[[FRICTION, DAMPING, SIDE_DAMPING, LEAN_DAMPING]] = 0.0
        tilt = 0.0 if p[JEWEL] else self.values.bearing_tilt_rad
        moment, axis = np.array([math.cos(tilt), 0.0, -math.sin(tilt)]), np.array([0.0, 0.0, 1.0])
        small, scale = np.zeros(5), self.omega_rad_per_s**2

        def state(at: Array) -> Array:
            turn = rotation_from_rodrigues(at[2:])
            y = np.zeros(STATES)
            y[:2], y[MOMENT : MOMENT + 3] = at[:2], turn @ moment
            y[AXIS : AXIS + 3] = turn @ axis if not p[JEWEL] else 0.0
            return y

        many = np.repeat(p[:, None], LANES, axis=1)

        def pulls(places: Array) -> Array:
            """(places, 5) of places (places, 5)."""
            states = [state(at) for at in places]
            rates = [
                accelerations(np.stack(padded(states[k : k + LANES]), axis=1), many)
                for k in range(0, len(states), LANES)
            ]
            rate = np.concatenate(rates, axis=1)[:, : len(places)].T
            return np.concatenate([rate[:, 2:4], rate[:, OMEGA:]], axis=1) / scale

        unit = np.eye(5) * LIMITS.rest_step
        for _ in range(LIMITS.rest_rounds):
            found = pulls(np.concatenate([small + unit, small - unit, [small]]))
            slope = (found[:5] - found[5:10]).T / (2.0 * LIMITS.rest_step)
            step = np.linalg.lstsq(slope, -found[10], rcond=LIMITS.rest_step)[0]
            small += step
            if not np.hypot(small[0], small[1]) < LIMITS.rest_farthest:
                break
            if np.abs(step).max() < LIMITS.rest_close:
                return state(small)
        raise NoRestError("magnets, bearing and gravity balance nowhere near the main axis")

    def start(self) -> Array:
        """The state (STATES,) in which the drive finds it: at rest, or in a motion that is left over.  NoRestError."""
        y, v = self.rest(), self.values
        if not any(v.start.values()):
            return y
        jewel = self.geometry.bearing == "jewel"
        y[:4] += v.start_place_u, v.start_place_v, v.start_place_u_per_s, v.start_place_v_per_s
        if not math.hypot(y[0], y[1]) < LIMITS.rest_farthest:
            raise NoRestError(f"the rotor begins {math.hypot(y[0], y[1]):.3g} of its link beside the main axis")
        lean = rotation_from_rodrigues(np.array([v.start_lean_u_rad, v.start_lean_v_rad, 0.0]))
        link = np.array([-y[0], -y[1], math.sqrt(1.0 - y[0] ** 2 - y[1] ** 2)])
        axis = link if jewel else lean @ y[AXIS : AXIS + 3]
        turn = rotation_from_rodrigues(axis * v.start_angle_rad)
        y[MOMENT : MOMENT + 3] = turn @ lean @ y[MOMENT : MOMENT + 3]
        y[OMEGA:] = axis * v.start_speed_rad_per_s
        if jewel:
            rate = self.geometry.link_m * np.array([y[2], y[3], (y[0] * y[2] + y[1] * y[3]) / link[2]])
            y[OMEGA:] += np.cross(link, rate) / self.geometry.radius_m
        else:
            y[AXIS : AXIS + 3] = axis
            y[OMEGA : OMEGA + 2] += v.start_lean_u_rad_per_s, v.start_lean_v_rad_per_s
        return y

    def tolerances(self) -> Array:
        """Tolerated error of each component of the state per step, (STATES,)."""
        explicit = LIMITS.contact_tolerance if self.geometry.bearing == "jewel" else LIMITS.tolerance
        tolerance = LIMITS.sticking_tolerance if self.sticks else explicit
        scale = np.full(STATES, LIMITS.side_factor * tolerance)
        scale[[MOMENT, MOMENT + 1, OMEGA + 2]] = tolerance
        scale[2:4] *= self.omega_rad_per_s
        scale[OMEGA:] *= self.omega_rad_per_s
        return scale

    def dm_dt(self, samples: int, rate_hz: float) -> tuple[Array, Array]:
        """dm/dt in world axes, (3, samples) A m^2/s, and the ends of the steps, s.

        Raises NoRestError, LostRotorError.
        """
        found, _, ends = self.dm_dt_beside((), samples, rate_hz)
        return found, ends

    def dm_dt_beside(
        self, neighbours: Sequence[RigidRotor], samples: int, rate_hz: float, *, late_s: Sequence[float] = ()
    ) -> tuple[Array, list[Array | None], Array]:
        """dm/dt as `dm_dt` has it, that of up to LANES - 1 neighbours at the same steps, and the ends of the steps, s.

        late_s: after the neighbours comes its own dm/dt once more for each of them, sampled so much later.

        Raises NoRestError, and LostRotorError for this rotor; a neighbour whose motion runs away is None.
        """
        motions, ends = motions_beside([self, *neighbours], samples, rate_hz, late_s=late_s)
        last_s = self.drive.rx_start_s + self.values.drive_delay_s + (samples - 1) / rate_hz
        if ends.size == 0 or ends[-1] < last_s:
            raise LostRotorError("the rotor's motion cannot be followed")
        found = motions[0]
        if found is None:
            raise LostRotorError("the rotor's motion runs away")
        return found, motions[1:], ends
