"""Omnibus tests for a missing effect without a name: any smooth torque, any slow change of any harmonic.

The tests only show whether something is missing; the torque estimated from them is drawn as a map.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre
from scipy.stats import chi2 as chi2_distribution

from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.information import solved
from platform_daemon.diagnosis.regression.joint_fit import JointFit, starting_strengths
from platform_daemon.diagnosis.regression.linearised_shot import LinearisedShot
from platform_daemon.diagnosis.regression.torque_response import sample_motion, torque_responses
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

_LIMITS = THRESHOLDS.selection


@dataclass(frozen=True, kw_only=True)
class OmnibusScore:
    """What a block of columns would gain: fall of chi^2 over the noise factor, and the number of its directions.

    information, gradient: of its columns, fitted parameters eliminated; power: of the columns as they are.
    """

    gain: float
    directions: int
    information: Array
    gradient: Array
    power: Array

    @property
    def p_value(self) -> float:
        """Chance of such a gain if nothing is missing."""
        return float(chi2_distribution.sf(self.gain, self.directions)) if self.directions else 1.0

    @property
    def excess(self) -> float:
        """Gain beyond what noise alone would give."""
        return max(0.0, self.gain - self.directions)


@dataclass(frozen=True)
class OmnibusTest:
    """What a smooth torque, and what slow changes of the harmonics would gain."""

    torque: OmnibusScore
    envelopes: OmnibusScore
    scale: tuple[float, float]  # largest |phi| in rad and |v| that the torque's polynomials are drawn over

    @property
    def p_value(self) -> float:
        """Of both together, corrected for their number."""
        return min(1.0, 2.0 * min(self.torque.p_value, self.envelopes.p_value))

    @property
    def excess(self) -> float:
        """Of the one that gains more."""
        return max(self.torque.excess, self.envelopes.excess)


def powers() -> list[tuple[int, int]]:
    """Powers (i, j) of phi and v in the smooth torque; a constant too."""
    return [(i, n - i) for n in range(_LIMITS.polynomial_degree + 1) for i in range(n, -1, -1)]


def monomials(phi: Array, v: Array, scale: tuple[float, float]) -> Array:
    """Torques (k, n) that are products of powers of the scaled angle and velocity."""
    x, y = phi / scale[0], v / scale[1]
    of_x, of_y = (_powers_of(z) for z in (x, y))
    return np.stack([of_x[i] * of_y[j] for i, j in powers()])


def _powers_of(z: Array) -> list[Array]:
    """z to the powers 0 to the highest; ten times faster than one by one."""
    return list(itertools.accumulate([z] * _LIMITS.polynomial_degree, np.multiply, initial=np.ones_like(z)))


def omnibus_test(at: JointFit, pool: Executor) -> OmnibusTest:
    """Test of the residuals of all shots."""
    amplitude = max(abs(s.dynamics.amplitude) for s in at.states)
    scale = amplitude, 2.0 * math.sin(0.5 * amplitude)
    parts = list(pool.map(lambda k: _one(at, k, scale), range(len(at.linear))))
    torque = _gained(at, [p[0] for p in parts])
    envelopes = _gained(at, [p[1] for p in parts])
    return OmnibusTest(torque, envelopes, scale)


_Part = tuple[Array, Array, Array]


def _one(at: JointFit, k: int, scale: tuple[float, float]) -> tuple[_Part, _Part]:
    """(information, gradient, power) of the smooth torque and of the envelopes in one shot."""
    prepared, linear = at.prepared[k], at.linear[k]
    # Torques that depend on time have no tables; they change the motion too little to matter here.
    effects = at.hypothesis.effects
    still = tuple(c for c in effects if c.kick_at_s is not None or (c.term is not None and not c.term.timed))
    hypothesis = Hypothesis(at.hypothesis.model, still)
    model = hypothesis.augmented
    try:
        state = hypothesis.extended(at.states[k], starting_strengths(at, hypothesis))
        answers = torque_responses(prepared, model, state, lambda phi, v: monomials(phi, v, scale))
        torque = linear.linearisation.white(answers)
    except LostTrajectoryError:
        torque = np.zeros((len(powers()), linear.residual.size))
    phase = sample_motion(prepared, at.hypothesis.augmented, at.full_state(k)).phase
    envelopes = linear.linearisation.white(_envelopes(phase, prepared.time_s, linear))
    accepted = linear.columns.T
    return linear.projected(np.concatenate([accepted, torque])), linear.projected(np.concatenate([accepted, envelopes]))


def _envelopes(phase: Array, time_s: Array, linear: LinearisedShot) -> Array:
    """Harmonics of the motion with slowly changing sizes in every channel, (k, channels, m)."""
    channels = linear.linearisation.residual.shape[0]
    place = 2.0 * (time_s - time_s[0]) / (time_s[-1] - time_s[0]) - 1.0
    slow = legendre.legvander(place, _LIMITS.envelope_degrees - 1).T
    waves = [w for h in range(1, _LIMITS.envelope_harmonics + 1) for w in (np.cos(h * phase), np.sin(h * phase))]
    rows = np.stack([s * w for s in slow for w in waves])
    out = np.zeros((channels * rows.shape[0], channels, time_s.size))
    for c in range(channels):
        out[c * rows.shape[0] : (c + 1) * rows.shape[0], c] = rows
    return out


def _gained(at: JointFit, parts: Sequence[_Part]) -> OmnibusScore:
    """Sum over all shots, the common strengths eliminated."""
    information, gradient, power = (sum(x[1:], start=x[0]) for x in zip(*parts, strict=True))
    q = at.hypothesis.size
    if q:
        cross = solved(information[:q, :q], np.column_stack([information[:q, q:], gradient[:q]]))
        gradient = gradient[q:] - information[q:, :q] @ cross[:, -1]
        information = information[q:, q:] - information[q:, :q] @ cross[:, :-1]
        power = power[q:]
    scale = 1.0 / np.sqrt(np.maximum(power, 1e-300))
    values, vectors = np.linalg.eigh(information * np.outer(scale, scale))
    visible = values > _LIMITS.direction_share
    along = vectors[:, visible].T @ (gradient * scale)
    gain = float(np.sum(along**2 / values[visible])) / at.noise_factor
    return OmnibusScore(
        gain=gain, directions=int(visible.sum()), information=information, gradient=gradient, power=power
    )
