"""A ring-down whose parameters are all known: from a fit, or from published numbers.

Every derived quantity is computed from this one object and the traced motion, so that it holds for any declared
model, whatever its torque terms.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ellipk, ellipkinc

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.thresholds import THRESHOLDS

from .models import RingDownModel, model_named
from .trajectory.basis_functions import STATE
from .trajectory.direct import MotionParameters, Trajectory
from .trajectory.initial_conditions import state_of_initial_conditions
from .trajectory.turning_points import turning_points

LIMITS = THRESHOLDS.physics


@dataclass(frozen=True)
class RingDown:
    """A motion and the moment that makes it visible.

    Attributes:
        model: the equation of motion.
        dynamics: its parameters.
        m_r_am2: magnetic moment in A m^2; None where it is unknown (raw volts without calibration).
    """

    model: RingDownModel
    dynamics: MotionParameters
    m_r_am2: float | None = None

    @classmethod
    def from_parameters(cls, variant: str | RingDownModel, values: Mapping[str, float]) -> RingDown:
        """A ring-down from published parameters (PARAMETER_NAMES; orientation is not needed).

        Raises:
            ValueError: unknown variant.
            KeyError: f_nat_hz, phi_max_rad, psi_start_rad or a coefficient of the model is missing.
        """
        model = model_named(variant) if isinstance(variant, str) else variant
        model = model.under_weight(values.get("weight_over_pull", 0.0))
        coefficients = tuple(values[c.name] for c in model.coefficients)
        phi, v = state_of_initial_conditions(values["phi_max_rad"], values["psi_start_rad"])
        dynamics = dynamics_through(model, w=2.0 * math.pi * values["f_nat_hz"], values=coefficients, phi=phi, v=v)
        return cls(model, dynamics, values.get("m_r_am2"))

    @property
    def f_nat_hz(self) -> float:
        """Natural frequency in Hz (eq:omega_nat)."""
        return self.dynamics.w / (2.0 * math.pi)

    def motion(self, samples: int, dt_s: float) -> tuple[Array, Array]:
        """(phi in rad, phi'/w) at t = 0, dt, ...: (samples,) each."""
        basis = Trajectory(self.model, self.dynamics, samples * dt_s).basis(0, samples, dt_s, STATE)
        return basis[0], basis[1]

    def peak_rate(self, time_s: Array) -> Array:
        """V = 2 sin(A/2) at rising times (n,): the peak of phi'/w on the undamped orbit of the present amplitude A.

        A is read at the turning points and interpolated between them; 0 once the rotor sticks.
        """
        times, peaks = self._turning_points(float(time_s[-1]))
        # Between neighbours the loss is so small that a straight line is exact to 1e-7.
        return np.interp(time_s, times, peaks, right=0.0)

    def _turning_points(self, until_s: float) -> tuple[Array, Array]:
        """(times, V) from the anchor, which lies before t = 0, to beyond until_s or until the rotor sticks."""
        if self.model.time_dependent:
            return self._sampled_turning_points(until_s)
        times, sizes = turning_points(self.model, self.dynamics, until_s)
        return times, 2.0 * np.sin(0.5 * sizes)

    def _sampled_turning_points(self, until_s: float) -> tuple[Array, Array]:
        """The same for any torque, from samples of the traced motion."""
        d = self.dynamics
        before = d.theta / d.w
        dt = 2.0 * math.pi / (d.w * LIMITS.turning_points_per_period)
        samples = math.ceil((before + until_s) / dt) + 2 * LIMITS.turning_points_per_period
        phi, v = replace(self, dynamics=replace(d, theta=0.0)).motion(samples, dt)
        last = np.flatnonzero(v[1:-1] * v[2:] < 0.0) + 1
        nearest = np.where(np.abs(v[last]) < np.abs(v[last + 1]), last, last + 1)
        # Losses vanish with the velocity, so the sample beside a turning point has its energy.
        peaks = np.hypot(v[nearest], 2.0 * np.sin(0.5 * phi[nearest]))
        times = dt * (last + v[last] / (v[last] - v[last + 1])) - before
        return np.append(-before, times), np.append(2.0 * math.sin(0.5 * abs(d.amplitude)), peaks)


def dynamics_through(
    model: RingDownModel, *, w: float, values: tuple[float, ...], phi: float, v: float
) -> MotionParameters:
    """The trajectory that passes through (phi, v = phi'/w) at t = 0, anchored at a turning point before it.

    Starts from the undamped orbit (equ:ODE_norm) through the state and corrects with Newton's method on the exact
    derivatives.

    Raises:
        ValueError: at rest, or so fast that the rotor turns over.
    """
    dynamics = _undamped(w, values, phi, v)
    for _ in range(LIMITS.anchor_steps):
        basis = Trajectory(model, dynamics, 0.0).basis(0, 1, 1.0, STATE)[:, 0]
        miss = np.array([phi - basis[0], v - basis[1]])
        # Columns theta and A of the state's derivatives.
        step = np.linalg.solve(np.array([[basis[2], basis[6]], [basis[3], basis[7]]]), miss)
        dynamics = MotionParameters(
            w=w, theta=dynamics.theta + float(step[0]), amplitude=dynamics.amplitude + float(step[1]), values=values
        )
        if float(np.max(np.abs(step))) < LIMITS.anchor_close * max(1.0, abs(dynamics.theta)):
            break
    return dynamics


def _undamped(w: float, values: tuple[float, ...], phi: float, v: float) -> MotionParameters:
    """Elliptic orbit through the state; the anchor lies a quarter to three quarters of a period before it."""
    m = 0.25 * v * v + math.sin(0.5 * phi) ** 2
    if not 0.0 < m < 1.0:
        raise ValueError(f"no oscillation passes through phi = {phi:.4g} rad, phi'/w = {v:.4g}")
    k, quarter = math.sqrt(m), float(ellipk(m))
    # sin(phi/2) = k cd(s), v = -2 k sqrt(1 - m) sd(s) with s counted from the turning point phi = +A: s = K + x.
    x = float(ellipkinc(math.asin(max(-1.0, min(1.0, -math.sin(0.5 * phi) / k))), m))
    if v > 0.0:
        x = 2.0 * quarter - x
    since = quarter + x
    anchor = 2.0 * math.asin(k)
    if since < quarter:
        since, anchor = since + 2.0 * quarter, -anchor
    elif since > 3.0 * quarter:
        since, anchor = since - 2.0 * quarter, -anchor
    return MotionParameters(w=w, theta=since, amplitude=anchor, values=values)
