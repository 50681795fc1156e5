"""What a shot does to coils and amplifier, from the exact samples of its timeline."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from drivers.timeline import Timeline
from sequences.drive import ChannelDrive

TAIL = 20.0  # time constants of the loop after which its current has died


@dataclass(frozen=True)
class CoilFigures:
    """One coil: highest voltage at the amplifier's output, V, and current, A; integral of its square, A^2 s; heat in
    the coil, J; energy that the amplifier delivers, J."""

    axis: str
    peak_v: float
    peak_a: float
    i2t_a2s: float
    heat_j: float
    energy_j: float


@dataclass(frozen=True)
class ShotFigures:
    """All coils, and the largest field at the rotor, T."""

    coils: tuple[CoilFigures, ...]
    peak_field_t: float


def figures_of(timeline: Timeline, drives: Sequence[ChannelDrive]) -> ShotFigures:
    """Play the timeline into the loops, each a resistance and an inductance in series.

    The voltage is straight between samples, the current of the loop exact for that, until it has died after TX.
    """
    rate_hz = timeline.clock.rate_hz
    slowest_s = max((d.channel.inductance_h / d.channel.resistance_ohm for d in drives), default=0.0)
    samples = min(timeline.tx_samples + int(TAIL * slowest_s * rate_hz) + 2, timeline.total_samples)
    coils, field = [], np.zeros((3, samples))
    for d in drives:
        c = d.channel
        volts = c.amplifier_gain * timeline.output_volts(c.output, 0, samples)
        # Exact for straight pieces: i' = (v - R i) / L over one sample.
        x = c.resistance_ohm / (c.inductance_h * rate_hz)
        decay = np.exp(-x)
        average = -np.expm1(-x) / x
        b = np.array([1.0 - average, average - decay]) / c.resistance_ohm
        current = lfilter(b, [1.0, -decay], volts)
        field += np.outer(c.field_per_ampere_t, current)
        i2t = float(np.sum(current**2)) / rate_hz
        energy = float(np.sum(volts * current)) / rate_hz
        peaks = float(np.max(np.abs(volts))), float(np.max(np.abs(current)))
        coils.append(CoilFigures(c.axis, *peaks, i2t, c.resistance_ohm * i2t, energy))
    return ShotFigures(tuple(coils), float(np.max(np.linalg.norm(field, axis=0))) if drives else 0.0)
