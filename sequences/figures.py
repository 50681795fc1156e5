"""Load of coils and amplifier in a shot, computed from the exact samples of its timeline."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from drivers.calibration import TransmitChannel
from drivers.timeline import Timeline
from sequences.drive import ChannelDrive

PER_SAMPLE = 8  # points: a sine of an eighth of the sampling rate is right to 1e-3 then
TAIL = 20.0  # time constants of the loop after which its current has decayed


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
    """Load of each loop, a resistance and an inductance in series, from the start until the current has decayed.

    The voltage is taken as linear between points; the current is exact for that voltage.
    """
    rate_hz = PER_SAMPLE * timeline.clock.rate_hz
    slowest_s = max((d.channel.inductance_h / d.channel.resistance_ohm for d in drives), default=0.0)
    samples = min(timeline.tx_samples + int(TAIL * slowest_s * timeline.clock.rate_hz) + 2, timeline.total_samples)
    coils, field = [], np.zeros((3, PER_SAMPLE * samples))
    for d in drives:
        c = d.channel
        volts = c.amplifier_gain * timeline.output_volts(c.output, 0, samples, PER_SAMPLE)
        current = loop_current_a(volts, rate_hz, c)
        field += np.outer(c.field_per_ampere_t, current)
        i2t = float(np.sum(current**2)) / rate_hz
        energy = float(np.sum(volts * current)) / rate_hz
        peaks = float(np.max(np.abs(volts))), float(np.max(np.abs(current)))
        coils.append(CoilFigures(c.axis, *peaks, i2t, c.resistance_ohm * i2t, energy))
    return ShotFigures(tuple(coils), float(np.max(np.linalg.norm(field, axis=0))) if drives else 0.0)


def loop_current_a(volts: NDArray[np.float64], rate_hz: float, channel: TransmitChannel) -> NDArray[np.float64]:
    """Current of one coil at the points (n,) of a voltage (n,), A; zero at the first point."""
    x = channel.resistance_ohm / (channel.inductance_h * rate_hz)
    decay, average = float(np.exp(-x)), float(-np.expm1(-x) / x)
    pushed = (1.0 - average) * volts[1:] + (average - decay) * volts[:-1]
    steps = [0.0, *(pushed / channel.resistance_ohm).tolist()]
    return np.array(list(accumulate(steps, lambda i, push: decay * i + push)))
