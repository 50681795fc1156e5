"""What one angle does, and what a rotor does beside it, on a thinned grid of times.

What a rotor does beside one angle follows that motion for the most part: its amplitude and its phase drift slowly away
from those of one angle, and its other modes, too, are kept by a few slow harmonics of that motion's phase.
"""

from __future__ import annotations

import numpy as np

from platform_daemon.estimation.moments.workspace import Workspace
from platform_daemon.estimation.numerics.arrays import Array
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


def rebuilt(harmonics: Array, phase: Array) -> Array:
    """(3, n) from harmonics (nodes, 3, HARMONICS), linear between the nodes; at least as many nodes as n needs."""
    n = phase.shape[1]
    blocks = -(-n // BETWEEN)
    padded = np.zeros((HARMONICS, blocks * BETWEEN))
    padded[:, :n] = phase
    by_block = padded.reshape(HARMONICS, blocks, BETWEEN).transpose(1, 0, 2)
    here, next_one = harmonics[:blocks] @ by_block, harmonics[1 : blocks + 1] @ by_block
    share = np.arange(BETWEEN) / BETWEEN
    found = here + share * (next_one - here)
    return np.asarray(found.transpose(1, 0, 2).reshape(3, -1)[:, :n])


def _cubic() -> Array:
    """Weights (TAPS, THIN) of the four neighbours of each sample between the second and the third of them."""
    x = np.arange(THIN) / THIN
    before, here = -x * (x - 1) * (x - 2) / 6, (x + 1) * (x - 1) * (x - 2) / 2
    after, last = -(x + 1) * x * (x - 2) / 2, (x + 1) * x * (x - 1) / 6
    return np.array([before, here, after, last])


_CUBIC = _cubic()


def thickened(thin: Array, samples: int) -> Array:
    """All samples (3, samples) of what is known at every THIN-th of them, (3, n), by cubics."""
    padded = np.concatenate([2.0 * thin[:, :1] - thin[:, 1:2], thin, thin[:, -1:], thin[:, -1:]], axis=1)
    neighbours = np.lib.stride_tricks.sliding_window_view(padded, TAPS, axis=1)
    return np.asarray((neighbours @ _CUBIC).reshape(3, -1)[:, :samples])
