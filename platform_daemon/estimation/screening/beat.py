"""Two resonators that no fit got through: seen in the fundamental itself, without any model of the motion.

The fundamental of one resonator is one complex function of time along one direction of the channels. Two resonators
span two directions, or, along the same direction, beat: a sum of two decaying rotations.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array, ComplexArray
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.screening


@dataclass(frozen=True, kw_only=True)
class Beat:
    """Two oscillations: frequencies in Hz, the larger one first, and the ratio of their sizes."""

    frequencies_hz: tuple[float, float]
    ratio: float


def find_beat(record: RingDownRecord, *, first: int, last: int, frequency_hz: float, noise_sd: Array) -> Beat | None:
    """Two oscillations near the fundamental in the first sixty periods of samples first .. last-1, or None.

    noise_sd: (channels,) of a sample.
    """
    envelope, hop_s, noise = _envelope(record, first, last, frequency_hz)
    if envelope.shape[1] < LIMITS.beat_fewest_points:
        return None
    sizes = np.linalg.svd(envelope, compute_uv=False)
    noise_size = LIMITS.beat_over_noise * noise * float(noise_sd.max()) * math.sqrt(envelope.shape[1])
    two_directions = sizes.size > 1 and sizes[1] > max(LIMITS.beat_smallest_ratio * sizes[0], noise_size)
    poles, amplitudes, left = _rotations(
        envelope, 1 if two_directions else envelope.shape[1] // LIMITS.beat_lag_divisor, 2
    )
    _, _, left_by_one = _rotations(envelope, envelope.shape[1] // LIMITS.beat_lag_divisor, 1)
    # One resonator spans one direction. It may change its frequency, but then two rotations do not follow it exactly.
    beating = left_by_one > LIMITS.beat_left_by_one_share and left < LIMITS.beat_left_ratio * left_by_one
    if not (beating or (two_directions and left < LIMITS.beat_left_by_two_share)):
        return None
    order = np.argsort(-amplitudes)
    found = frequency_hz + np.angle(poles[order]) / (2.0 * math.pi * hop_s)
    ratio = float(amplitudes[order[1]] / amplitudes[order[0]])
    apart = abs(found[0] - found[1]) > LIMITS.beat_apart_cycles / (envelope.shape[1] * hop_s)
    return (
        Beat(frequencies_hz=(float(found[0]), float(found[1])), ratio=ratio)
        if apart and ratio > LIMITS.beat_smallest_ratio
        else None
    )


def _envelope(record: RingDownRecord, first: int, last: int, frequency_hz: float) -> tuple[ComplexArray, float, float]:
    """Complex envelope (channels, points) of the fundamental, its step in s, and its noise over that of a sample."""
    period = record.sampling_rate_hz / frequency_hz
    length = round(LIMITS.beat_point_periods * period)
    hop = round(LIMITS.beat_hop_periods * period)
    points = 1 + (min(last - first, int(LIMITS.beat_stretch_periods * period)) - length) // hop
    # The second harmonic is four bins away, where this window lets nothing through.
    window = np.blackman(length + 1)[:-1]
    wave = window * np.exp(-2j * np.pi * np.arange(length) / period)
    rows = []
    for k in range(max(points, 0)):
        begin = first + k * hop
        piece = record.samples[:, begin : begin + length]
        turn = np.exp(-2j * np.pi * k * hop / period)
        rows.append((piece - piece.mean(axis=1, keepdims=True)) @ wave * turn)
    envelope = np.array(rows).T if rows else np.empty((record.channels, 0), dtype=complex)
    return envelope, hop * record.dt_s, float(np.linalg.norm(window))


def _rotations(envelope: ComplexArray, lags: int, count: int) -> tuple[ComplexArray, Array, float]:
    """Poles (count,) of the best sum of decaying rotations, their initial sizes, and the power share left (ESPRIT)."""
    n = envelope.shape[1]
    columns = n - lags + 1
    stacked = np.concatenate([envelope[:, k : k + columns] for k in range(lags)])
    _, _, rows = np.linalg.svd(stacked, full_matrices=False)
    basis = rows[:count].T
    poles: ComplexArray = np.linalg.eigvals(np.linalg.lstsq(basis[:-1], basis[1:], rcond=None)[0]).astype(complex)
    powers = poles[None, :] ** np.arange(n)[:, None]
    amplitudes, *_ = np.linalg.lstsq(powers, envelope.T, rcond=None)
    left = np.sum(np.abs(envelope.T - powers @ amplitudes) ** 2) / np.sum(np.abs(envelope) ** 2)
    return poles, np.asarray(np.linalg.norm(amplitudes, axis=1)), float(left)
