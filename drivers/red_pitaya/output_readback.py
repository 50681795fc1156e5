"""Outputs at zero: the commands that set them, the questions that read them back, and the check of the answers."""

from __future__ import annotations

from collections.abc import Sequence

from drivers.red_pitaya.sequence import COMPONENTS

SINES = [(output, component) for output in (0, 1) for component in range(COMPONENTS)]
OUTPUTS_OFF = [
    *(f"RP:DAC:CHANNEL{o}:COMPONENT{c}:AMPLITUDE 0" for o, c in SINES),
    *(f"RP:DAC:CHANNEL{o}:OFFSET 0" for o in (0, 1)),
]
READ_BACK = [
    *(f"RP:DAC:CHANNEL{o}:COMPONENT{c}:AMPLITUDE?" for o, c in SINES),
    *(f"RP:DAC:CHANNEL{o}:OFFSET?" for o in (0, 1)),
]
OFF_TOLERANCE_V = 1e-4  # an offset register may read back its calibration's last digit


def all_off(found: Sequence[str | int | float], at_most_v: float) -> bool:
    """Answers to READ_BACK, then levels of lines: voltages no larger than this, lines low."""
    volts = found[: len(READ_BACK)]
    levels = found[len(READ_BACK) :]
    return all(abs(float(v)) <= at_most_v for v in volts) and all(level == "OFF" for level in levels)
