"""What one angle does, and what a rotor does beside it, on a thinned grid of times.

What a rotor does beside one angle follows that motion for the most part: its amplitude and its phase drift slowly away
from those of one angle, and its other modes, too, are kept by a few slow harmonics of that motion's phase.
"""

from __future__ import annotations

import numpy as np

from platform_daemon.estimation.moments.workspace import Workspace
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.numerics.jit import fast_kernel
from platform_daemon.estimation.physics.trajectory.basis_functions import STATE
from platform_daemon.estimation.physics.trajectory.direct import MotionParameters
from platform_daemon.estimation.thresholds import THRESHOLDS

from .coordinates import TURNS, OneAngle, OneAngleCoordinates

LIMITS = THRESHOLDS.rotor_correction
HARMONICS = 1 + 2 * LIMITS.harmonics
THIN, BETWEEN = LIMITS.thin, LIMITS.samples_per_node
TAPS = 4


def motion(
    coordinates: OneAngleCoordinates, dynamics: MotionParameters, samples: int, step_s: float
) -> tuple[Array, Array]:
    """sin(phi/2) and v = phi'/w of a motion from t = 0 on, (n,) each.  Raises LostTrajectoryError."""
    phi, v = Workspace(coordinates.model).block_means(
        dynamics, begin=0, blocks=samples, block=1, dt_s=step_s, observable=STATE, accuracy=0.0
    )
    return np.sin(0.5 * phi), v


def dm_dt_of(
    coordinates: OneAngleCoordinates, at: OneAngle, dynamics: MotionParameters, half: Array, v: Array
) -> Array:
    """dm/dt (3, n), A m^2/s, world axes, of what `motion` returned."""
    speed = at.m_r_am2 * dynamics.w * v
    sine = 2.0 * half * np.sqrt(1.0 - half * half)
    seen = np.stack([-sine * speed, (1.0 - 2.0 * half * half) * speed])
    return np.asarray(coordinates.rotated(at.vector[-TURNS:])[:, :2] @ seen)


def harmonics_of(half: Array, v: Array) -> Array:
    """Harmonics of the phase of what `motion` returned, (HARMONICS, n)."""
    size = 1.0 / np.sqrt(np.maximum(4.0 * half * half + v * v, np.finfo(float).tiny))
    turning = np.empty(half.size, dtype=np.complex128)
    turning.real, turning.imag = 2.0 * half * size, -v * size
    rows = np.empty((HARMONICS, half.size))
    rows[0], power = 1.0, turning
    for k in range(LIMITS.harmonics):
        rows[2 * k + 1], rows[2 * k + 2] = power.real, power.imag
        power = power * turning
    return rows


def slow_harmonics(difference: Array, phase: Array) -> Array:
    """Of what a rotor does beside one angle, (3, n), the harmonics (nodes, 3, HARMONICS) about each node in time.

    phase: (HARMONICS, n).  Least squares in windows of two nodes' distance on either side, with a linear drift.
    """
    n = difference.shape[1]
    nodes = np.arange(0, n + BETWEEN, BETWEEN)
    window = np.hanning(2 * BETWEEN + 1)
    found = np.zeros((nodes.size, 3, HARMONICS))
    for k, node in enumerate(nodes.tolist()):
        first, last = max(0, node - BETWEEN), min(n, node + BETWEEN + 1)
        weight = window[first - node + BETWEEN : last - node + BETWEEN]
        since = (np.arange(first, last) - node) / BETWEEN
        if last - first < LIMITS.fewest_samples:
            found[k] = found[k - 1]
            continue
        rows = np.concatenate([phase[:, first:last], phase[:, first:last] * since]) * weight
        known = rows @ (difference[:, first:last] * weight).T
        found[k] = np.linalg.lstsq(rows @ rows.T, known, rcond=LIMITS.ridge)[0][:HARMONICS].T
    return found


def _cubic() -> Array:
    """Weights (TAPS, THIN) of the four neighbours of each sample between the second and the third of them."""
    x = np.arange(THIN) / THIN
    before, here = -x * (x - 1) * (x - 2) / 6, (x + 1) * (x - 1) * (x - 2) / 2
    after, last = -(x + 1) * x * (x - 2) / 2, (x + 1) * x * (x - 1) / 6
    return np.array([before, here, after, last])


_CUBIC = _cubic()


def less_harmonics(samples: Array, harmonics: Array, phase: Array) -> Array:
    """Samples (3, n) less what slow harmonics make of a phase.

    harmonics: (nodes, 3, HARMONICS), linear between the nodes; phase: (HARMONICS, thin), at every THIN-th sample and
    one beyond the last; between them by cubics.  Raises ValueError where nodes or places are fewer than samples need.
    """
    n, thin = samples.shape[1], phase.shape[1]
    if (thin - 1) * THIN < n or (harmonics.shape[0] - 1) * BETWEEN < thin:
        raise ValueError(f"{harmonics.shape[0]} nodes and {thin} places do not reach over {n} samples")
    out = np.empty(samples.shape)
    _subtract(samples, harmonics, phase, _CUBIC, out)
    return out


@fast_kernel
def _subtract(samples, harmonics, phase, cubic, out):  # type: ignore[no-untyped-def]
    """In one pass: a shot of 2 s is 3 MB, and each further array of that size costs as much as all the sums here."""
    thin, n = phase.shape[1], samples.shape[1]
    found = np.empty(thin + TAPS - 1)
    for c in range(samples.shape[0]):
        for node in range((thin + BETWEEN - 1) // BETWEEN):
            first = node * BETWEEN
            here = found[1 + first : 1 + min(thin, first + BETWEEN)]
            here[:] = 0.0
            for h in range(HARMONICS):
                value = harmonics[node, c, h]
                rise = (harmonics[node + 1, c, h] - value) / BETWEEN
                row = phase[h, first : first + here.size]
                for i in range(here.size):
                    here[i] += (value + i * rise) * row[i]
        found[0] = 2.0 * found[1] - found[2]
        found[thin + 1 :] = found[thin]
        whole = n // THIN
        for i in range(whole):
            before, at, after, last = found[i], found[i + 1], found[i + 2], found[i + 3]
            for j in range(THIN):
                between = before * cubic[0, j] + at * cubic[1, j] + after * cubic[2, j] + last * cubic[3, j]
                out[c, i * THIN + j] = samples[c, i * THIN + j] - between
        for j in range(n - whole * THIN):
            between = 0.0
            for k in range(TAPS):
                between += found[whole + k] * cubic[k, j]
            out[c, whole * THIN + j] = samples[c, whole * THIN + j] - between
