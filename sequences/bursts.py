"""From half periods of the field to the bursts that the I/O card plays on one output."""

from __future__ import annotations

import cmath
import math
from itertools import pairwise

import numpy as np

from drivers.errors import SequenceRejected
from drivers.io_card import CardCapabilities
from drivers.timeline import Burst
from sequences.drive import ChannelDrive
from sequences.lobes import Lobes
from sequences.windows import Windows

LEVEL_PHASE_RAD = 0.5 * math.pi  # of a burst of frequency 0, which is then its amplitude
FEWEST_LEVELS = 6.0  # of a staircase, per period


def sine_burst(drive: ChannelDrive, windows: Windows, phase_rad: float) -> Burst:
    """One sine over the whole TX window, which every card can play; phase_rad: of the field at its start, rad."""
    phase = float(np.mod(drive.phase_rad + phase_rad, 2 * np.pi))
    return Burst(drive.channel.output, 0, windows.tx_samples, windows.frequency_hz, drive.dac_v, phase)


def lobe_bursts(drive: ChannelDrive, lobes: Lobes, tx_samples: int, card: CardCapabilities) -> tuple[Burst, ...]:
    """The bursts whose voltage makes the current of one coil follow the half periods.

    A sine becomes one sine per half period, or, on a card that cannot change a running sine, levels that are constant
    on the card's grid.  A rectangle becomes levels.  Raises SequenceRejected if the card can play neither.
    """
    if lobes.waveform == "sine" and card.retunes:
        return _sines(drive, lobes, tx_samples, card.clock.rate_hz)
    if not card.holds_levels:
        what = "a rectangle" if lobes.waveform == "rectangle" else "a field whose frequency changes"
        raise SequenceRejected(
            f"the I/O card cannot play {what}",
            where="sequence.waveform" if lobes.waveform == "rectangle" else "sequence.phase_plan",
            why="an output of it plays one running sine per shot and holds no levels",
            remedy="use a sine of constant frequency, or another card",
        )
    if lobes.waveform == "rectangle":
        return _rectangles(drive, lobes, tx_samples, card)
    return _staircase(drive, lobes, tx_samples, card)


def _sines(drive: ChannelDrive, lobes: Lobes, tx_samples: int, rate_hz: float) -> tuple[Burst, ...]:
    """One sine per half period; edges are on samples, and the distance to the zero of the field is a phase."""
    starts = np.clip(np.ceil(lobes.zeros_s * rate_hz - 1e-6).astype(int), 0, tx_samples)
    bursts = []
    for k, sign in enumerate(lobes.signs()):
        half_s = float(lobes.zeros_s[k + 1] - lobes.zeros_s[k])
        if starts[k] < starts[k + 1]:
            volts, ahead = _dac(drive, 0.5 / half_s)
            inside = math.pi * (starts[k] / rate_hz - float(lobes.zeros_s[k])) / half_s
            phase = math.fmod(inside + ahead + (math.pi if sign < 0 else 0.0), 2 * math.pi)
            bursts.append(Burst(drive.channel.output, int(starts[k]), int(starts[k + 1]), 0.5 / half_s, volts, phase))
    return tuple(bursts)


def _staircase(drive: ChannelDrive, lobes: Lobes, tx_samples: int, card: CardCapabilities) -> tuple[Burst, ...]:
    """Levels with the voltage in the middle of each step, scaled so that the fundamental has the sine's amplitude."""
    step_s = card.step_samples / card.clock.rate_hz
    fastest_hz = 0.5 / float(np.min(np.diff(lobes.zeros_s)))
    if fastest_hz * step_s * FEWEST_LEVELS > 1:
        raise SequenceRejected(
            f"the I/O card plays {1 / (fastest_hz * step_s):.1f} levels per period of {fastest_hz:.4g} Hz",
            where="sequence.f_tx_hz",
            why=f"a field that changes its frequency is played in levels of {card.step_samples} samples on this card, "
            f"at least {FEWEST_LEVELS:g} per period",
            remedy="lower io_card.step_samples or the frequency, or use a sine of constant frequency",
        )
    bursts = []
    for start in range(0, tx_samples, card.step_samples):
        middle_s = (start + 0.5 * card.step_samples) / card.clock.rate_hz
        k = int(np.searchsorted(lobes.zeros_s, middle_s, side="right")) - 1
        if 0 <= k < len(lobes):
            half_s = float(lobes.zeros_s[k + 1] - lobes.zeros_s[k])
            volts, ahead = _dac(drive, 0.5 / half_s)
            place = (middle_s - float(lobes.zeros_s[k])) / half_s
            level = lobes.signs()[k] * volts * math.sin(math.pi * place + ahead) / np.sinc(0.5 * step_s / half_s)
            bursts.append(_level(drive, start, start + card.step_samples, float(level)))
    return tuple(bursts)


def _rectangles(drive: ChannelDrive, lobes: Lobes, tx_samples: int, card: CardCapabilities) -> tuple[Burst, ...]:
    """Levels of the voltage whose steady current makes the field, advanced by the loop's delay at its frequency."""
    rate_hz, step = card.clock.rate_hz, card.step_samples
    level = drive.current_a * drive.channel.resistance_ohm / drive.channel.amplifier_gain
    bursts: list[Burst] = []
    for (start_s, stop_s), sign in zip(pairwise(lobes.zeros_s.tolist()), lobes.signs(), strict=True):
        half_s = stop_s - start_s
        late_s = cmath.phase(drive.channel.impedance_ohm(0.5 / half_s)) * half_s / math.pi
        middle_s = 0.5 * (start_s + stop_s) - late_s
        edges = [step * round((middle_s + side * 0.5 * lobes.duty * half_s) * rate_hz / step) for side in (-1, 1)]
        first, last = max(edges[0], bursts[-1].stop_sample if bursts else 0), min(edges[1], tx_samples)
        if first < last:
            bursts.append(_level(drive, first, last, float(sign) * level))
    return tuple(bursts)


def _dac(drive: ChannelDrive, frequency_hz: float) -> tuple[float, float]:
    """Amplitude at the DAC, V, and phase advance against the field, rad, of a sine of this frequency."""
    impedance = drive.channel.impedance_ohm(frequency_hz)
    turned = math.pi if drive.current_a < 0 else 0.0
    return abs(drive.current_a) * abs(impedance) / drive.channel.amplifier_gain, cmath.phase(impedance) + turned


def _level(drive: ChannelDrive, start: int, stop: int, volts: float) -> Burst:
    return Burst(drive.channel.output, start, stop, 0.0, volts, LEVEL_PHASE_RAD)
