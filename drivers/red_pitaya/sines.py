"""Sines of a shot as commands, and their amplitudes read back.

The server takes volts, multiplies them by the output's scale, truncates to a register of 65534 steps, and answers
volts again: the register divided by the scale.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from drivers.errors import DeviceProtocolError
from drivers.red_pitaya.sequence import Sine

LAST_STEP = 65534
AMPLITUDE_STEP_V = 1 / LAST_STEP  # divided by the output's scale
READ_BACK_STEPS = 1.001  # the last step of all can be missed by a whole one
SCALE_ROUNDING = 5e-6  # of the scale: the server reports six digits, and divides by the exact value


def arming(sines: Sequence[Sine], scales: Sequence[float]) -> tuple[list[str], list[str], list[str]]:
    """Commands for frequencies and phases, for amplitudes, and questions for the amplitudes."""
    waves = [command for sine in sines for command in _wave(sine)]
    volts = [_truncated(s.amplitude_v, scale) for s, scale in zip(sines, scales, strict=True)]
    amplitudes = [f"{_component(s)}:AMPLITUDE {v:.15g}" for s, v in zip(sines, volts, strict=True)]
    return waves, amplitudes, [f"{_component(s)}:AMPLITUDE?" for s in sines]


def check_amplitudes(sines: Sequence[Sine], scales: Sequence[float], found_v: Sequence[float], where: str) -> None:
    """Raises DeviceProtocolError if an amplitude reads back wrong by more than a step of its register, V.

    What the rounding of the scale makes of it comes on top: near full scale that is up to a third of a step.
    """
    for sine, scale, value in zip(sines, scales, found_v, strict=True):
        most_v = READ_BACK_STEPS * AMPLITUDE_STEP_V / scale + SCALE_ROUNDING * sine.amplitude_v
        if not abs(value - sine.amplitude_v) <= most_v:
            raise DeviceProtocolError(
                f"an amplitude of {sine.amplitude_v} V reads back as {value} V, at an output scale of {scale:g}",
                where=where,
                remedy="check the output calibration in the card's memory",
            )


def _component(sine: Sine) -> str:
    return f"RP:DAC:CHANNEL{sine.output}:COMPONENT{sine.component}"


def _wave(sine: Sine) -> list[str]:
    head = _component(sine)
    return [f"{head}:FREQUENCY {sine.frequency_hz:.15g}", f"{head}:PHASE {sine.phase_rad:.15g}"]


def _truncated(volts: float, scale: float) -> float:
    """The voltage to ask for so that the truncating register, `volts * scale` in steps, ends on the nearest step.

    In the middle of a step, because the scale is known to six digits only; the last one is the limit itself, which
    only a scale of one hits exactly.
    """
    steps = math.floor(volts * scale / AMPLITUDE_STEP_V + 0.5)
    middle = steps + 0.5 if steps < LAST_STEP else LAST_STEP if scale == 1.0 else LAST_STEP - 0.5
    return middle * AMPLITUDE_STEP_V / scale if steps else 0.0
