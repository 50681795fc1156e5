"""Two resonators that no fit got through: seen in the fundamental itself, without any model of the motion.

The fundamental of one resonator is one complex function of time along one direction of the channels. Two resonators
span two directions, or, along the same direction, beat: a sum of two decaying rotations.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..numerics.arrays import Array, ComplexArray
from ..record import RingDownRecord

_PERIODS = 4  # in a point of the envelope
_HOP_PERIODS = 1.5
_STRETCH_PERIODS = 60
_SMALLEST = 0.05  # of the larger one
_LEFT_BY_TWO = 0.25  # of the envelope's power
_ABOVE_NOISE = 3.0  # neighbouring points share samples
_BEATING = 0.005  # of what one rotation leaves
_LEFT_BY_ONE = 0.05
_APART = 0.1  # over the stretch: nearer ones are one


@dataclass(frozen=True)
class Beat:
    """Two oscillations: frequencies in Hz, the larger one first, and the ratio of their sizes."""

    frequencies_hz: tuple[float, float]
    ratio: float


def find_beat(record: RingDownRecord, first: int, last: int, frequency_hz: float, noise_sd: Array) -> Beat | None:
    """Two oscillations near the fundamental in the first sixty periods of samples first .. last-1, or None.

    noise_sd: (channels,) of a sample.
    """
    envelope, hop_s, noise = _envelope(record, first, last, frequency_hz)
    if envelope.shape[1] < 12:
        return None
    sizes = np.linalg.svd(envelope, compute_uv=False)
    noise_size = _ABOVE_NOISE * noise * float(noise_sd.max()) * math.sqrt(envelope.shape[1])
    two_directions = sizes.size > 1 and sizes[1] > max(_SMALLEST * sizes[0], noise_size)
    poles, amplitudes, left = _rotations(envelope, 1 if two_directions else envelope.shape[1] // 3, 2)
    _, _, left_by_one = _rotations(envelope, envelope.shape[1] // 3, 1)
    # One resonator spans one direction. It may change its frequency, but then two rotations do not follow it exactly.
    beating = left_by_one > _LEFT_BY_ONE and left < _BEATING * left_by_one
    if not (beating or (two_directions and left < _LEFT_BY_TWO)):
        return None
    order = np.argsort(-amplitudes)
    found = frequency_hz + np.angle(poles[order]) / (2.0 * math.pi * hop_s)
    ratio = float(amplitudes[order[1]] / amplitudes[order[0]])
    apart = abs(found[0] - found[1]) > _APART / (envelope.shape[1] * hop_s)
    return Beat((float(found[0]), float(found[1])), ratio) if apart and ratio > _SMALLEST else None


def _envelope(record: RingDownRecord, first: int, last: int, frequency_hz: float) -> tuple[ComplexArray, float, float]:
    """Complex envelope (channels, points) of the fundamental, its step in s, and its noise over that of a sample."""
    period = record.sampling_rate_hz / frequency_hz
    length = round(_PERIODS * period)
    hop = round(_HOP_PERIODS * period)
    points = 1 + (min(last - first, int(_STRETCH_PERIODS * period)) - length) // hop
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
