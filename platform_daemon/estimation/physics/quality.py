"""How well a resonator keeps its signal: quality factors, envelopes, frequency trace (ssec:quantifying_mmrs_quality).

Envelope: at every turning point the rotor is on the undamped orbit of amplitude A; between them A follows a straight
line. That orbit's peak signals and its frequency are the envelopes:
    hat m_dot_v = 2 m_r omega_nat sin(A/2)
    hat m_dot_u = m_r omega_nat sqrt(2 (c - cos A) (1 - c^2)),   3 c = cos A + sqrt(3 + cos^2 A)
    f           = f_nat pi / (2 K(sin^2(A/2)))
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipk

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.thresholds import THRESHOLDS

from .ring_down import RingDown

LIMITS = THRESHOLDS.physics


@dataclass(frozen=True)
class Envelopes:
    """Envelopes of a ring-down (fig:amplitude_plot), arrays (n,).

    Attributes:
        time_s: from the first RX sample on.
        amplitude_rad: A, of the orbit the rotor is on; 0 once the rotor sticks.
        v_am2_per_s, u_am2_per_s: hat m_dot in the local v and u axes, A m^2/s.
        frequency_shift_hz: f(t) - f_nat.
    """

    time_s: Array
    amplitude_rad: Array
    v_am2_per_s: Array
    u_am2_per_s: Array
    frequency_shift_hz: Array


def quality_factor(f_nat_hz: float, lambda_per_s: float) -> float:
    """Q = omega_nat / (2 lambda) of viscous damping alone (eq:lambda)."""
    return math.pi * f_nat_hz / lambda_per_s


def envelopes(ring_down: RingDown, duration_s: float, points: int = LIMITS.envelope_points) -> Envelopes:
    """Envelopes at `points` equidistant times from 0 to duration_s.

    Raises:
        ValueError: m_r is unknown, or no time span.
    """
    if ring_down.m_r_am2 is None:
        raise ValueError("envelopes in A m^2/s need m_r: this record was fitted in volts, without a calibration")
    if not (duration_s > 0.0 and points > 1):
        raise ValueError(f"{points} points over {duration_s!r} s are no time span")
    times = np.linspace(0.0, duration_s, points)
    peak = ring_down.peak_rate(times)
    scale = ring_down.m_r_am2 * ring_down.dynamics.w
    return Envelopes(
        time_s=times,
        amplitude_rad=2.0 * np.arcsin(0.5 * peak),
        v_am2_per_s=scale * peak,
        u_am2_per_s=scale * _u_peak(peak),
        frequency_shift_hz=ring_down.f_nat_hz * (0.5 * np.pi / ellipk(0.25 * peak**2) - 1.0),
    )


def _u_peak(peak: Array) -> Array:
    """Largest |v sin(phi)| on the orbit with the peak rate V, cos A = 1 - V^2/2."""
    cos_a = 1.0 - 0.5 * peak**2
    c = (cos_a + np.sqrt(3.0 + cos_a**2)) / 3.0
    return np.asarray(np.sqrt(2.0 * np.maximum(c - cos_a, 0.0) * (1.0 - c) * (1.0 + c)))


def equivalent_quality_factor(ring_down: RingDown, duration_s: float = math.inf) -> float:
    """tilde Q over [0, T] (eq:tilde-Q), from the traced motion: any model, any amplitude, T to infinity by default.

    Its exponential, starting at max(hat m_dot_v), has the same area as the envelope. Infinity means: until friction
    holds the rotor; without friction, until 1/1000 is left, and its exponential continuation.

    Raises:
        ValueError: the envelope does not decay over [0, T], or T is not positive.
    """
    if math.isinf(duration_s):
        return 0.5 * ring_down.dynamics.w * _total_area(ring_down)
    if not duration_s > 0.0:
        raise ValueError(f"an equivalent quality factor needs a time span, not {duration_s!r} s")
    times = np.linspace(
        0.0, duration_s, max(1, math.ceil(duration_s * ring_down.f_nat_hz)) * LIMITS.envelope_points_per_period + 1
    )
    peak = _decaying(ring_down.peak_rate(times))
    filling = float(np.trapezoid(peak, times) / (peak.max() * duration_s))
    return 0.5 * ring_down.dynamics.w * duration_s / _exponent(filling)


def _decaying(peak: Array) -> Array:
    """The envelope itself, (n,).  Raises ValueError if it is not lower at its end than at its beginning."""
    if not peak[-1] < peak[0] * (1.0 - LIMITS.envelope_least_decay):
        raise ValueError(f"the envelope does not decay: it ends at {peak[-1] / peak[0]:.6f} of its beginning")
    return peak


def _exponent(filling: float) -> float:
    """x = T omega/(2 tilde Q) from (1 - exp(-x))/x = filling, the implicit equation eq:tilde-Q."""
    return float(
        brentq(
            lambda x: -math.expm1(-x) / x - filling,
            LIMITS.quality_least_exponent,
            2.0 / filling,
            xtol=LIMITS.quality_error,
            rtol=LIMITS.quality_relative_error,
        )
    )


def _total_area(ring_down: RingDown) -> float:
    """Integral of the v-envelope over its maximum to the end of the motion, in s."""
    periods = LIMITS.envelope_first_periods
    while True:
        times, peak = _course(ring_down, periods)
        _decaying(peak)
        if peak[-1] <= LIMITS.envelope_decayed * peak.max():
            break
        if periods >= LIMITS.envelope_most_periods:
            raise ValueError(
                f"the envelope does not decay: {peak[-1] / peak.max():.3g} is left after {periods} periods"
            )
        periods *= 2
    area = float(np.trapezoid(peak, times))
    if peak[-1] > 0.0:
        tenth = times.size // LIMITS.envelope_tail_divisor
        rate = math.log(peak[-1 - tenth] / peak[-1]) / (times[-1] - times[-1 - tenth])
        area += float(peak[-1] / rate)
    return area / float(peak.max())


def _course(ring_down: RingDown, periods: int) -> tuple[Array, Array]:
    """(times, V) over so many natural periods."""
    times = np.arange(periods * LIMITS.envelope_points_per_period + 1) / (
        ring_down.f_nat_hz * LIMITS.envelope_points_per_period
    )
    return times, ring_down.peak_rate(times)


def decay_time_s(ring_down: RingDown, left: float = THRESHOLDS.screening.d30_share) -> float:
    """Time until hat m_dot_v has fallen to `left` of its maximum, s; 0.3 gives the end of D30.

    Raises:
        ValueError: it never does.
    """
    periods = LIMITS.envelope_first_periods
    while periods <= LIMITS.envelope_most_periods:
        times, peak = _course(ring_down, periods)
        below = np.flatnonzero(peak < left * peak.max())
        if below.size:
            return float(times[below[0]])
        periods *= 2
    raise ValueError(f"the envelope does not fall to {left:g} of its maximum")
