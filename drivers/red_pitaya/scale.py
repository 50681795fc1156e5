"""What a card's memory says of its converters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import structlog
from numpy.typing import NDArray

from drivers.errors import DeviceProtocolError
from drivers.red_pitaya.options import CardTable
from drivers.red_pitaya.stream import cic_gain

log = structlog.get_logger()

INPUT_CALIBRATED = 0b1111  # flags: scale and offset of both inputs were set
CALIBRATION = [
    *(f"ADC:CHANNEL{k}:SCALE" for k in (0, 1)),
    *(f"DAC:CHANNEL{k}:SCALE" for k in (0, 1)),
    *(f"ADC:CHANNEL{k}:OFFSET" for k in (0, 1)),
]


@dataclass(frozen=True)
class Scale:
    """From the card's memory: volts per count and at count 0 of the two inputs, (2,) float32 each, whether they were
    ever measured, and what the server multiplies the voltages of the two outputs by; gain: counts of the recording per
    count of the converter."""

    scale_v: NDArray[np.float32]
    offset_v: NDArray[np.float32]
    calibrated: bool
    output: tuple[float, float]
    gain: float

    def full_scale_v(self, channel: int) -> float:
        """What the converter of an input can take."""
        return 32768 * self.gain * float(self.scale_v[channel])

    def ends_v(self, channel: int) -> tuple[float, float]:
        """The voltages of the converter's lowest and highest code."""
        full_v, offset = self.full_scale_v(channel), float(self.offset_v[channel])
        return -full_v + offset, full_v * 32767 / 32768 + offset


def read_scale(ask: Callable[..., list[str | int | float]], table: CardTable, where: str) -> Scale:
    """Ask the card.  Raises DeviceProtocolError if that makes no sense, or nothing was set and `table` wants it."""
    keys = [f"RP:CALIB:{what}?" for what in CALIBRATION]
    *values, flags = ask(*keys, "RP:CALIB:FLAGS")
    numbers = np.array(values, np.float32)
    calibrated = int(flags) & INPUT_CALIBRATED == INPUT_CALIBRATED
    if not np.all(np.isfinite(numbers)) or not np.all(numbers[:4] > 0):
        raise DeviceProtocolError(
            "the calibration in the card's memory makes no sense",
            where=where,
            why=", ".join(f"{key} is {value}" for key, value in zip(CALIBRATION, values, strict=True)),
            remedy="calibrate the card anew",
        )
    if not calibrated:
        log.warning("card_inputs_not_calibrated", card=where, scale_v=numbers[:2].tolist())
        if table.require_calibration:
            raise DeviceProtocolError(
                "the card's inputs were never calibrated",
                where=where,
                why=f"calibration flags are {int(flags):#06b}",
                remedy="calibrate them, or set io_card.require_calibration = false",
            )
    gain = cic_gain(table.decimation)
    outputs = (float(values[2]), float(values[3]))
    return Scale(numbers[:2] / np.float32(gain), numbers[4:], calibrated, outputs, gain)
