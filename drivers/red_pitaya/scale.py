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
    what.replace("#", str(k))
    for what in (
        "ADC:CHANNEL#:SCALE",
        "ADC:CHANNEL#:OFFSET",
        "DAC:CHANNEL#:SCALE",
        "DAC:CHANNEL#:OFFSET",
        "DAC:CHANNEL#:LIMIT:LOWER",
        "DAC:CHANNEL#:LIMIT:UPPER",
    )
    for k in (0, 1)
]
INPUT_FULL_SCALE_V = (0.5, 40.0)  # the jumpers choose 1 V or 20 V
INPUT_OFFSET = 0.25  # of full scale
OUTPUT_SCALE = (0.5, 2.0)  # 2: calibrated into 50 ohm
OUTPUT_OFFSET_V = 0.1  # of a converter; the card puts it out all the time, amplifier on or off


@dataclass(frozen=True)
class Scale:
    """From the card's memory: volts per count and at count 0 of the two inputs, (2,) float32 each, whether they were
    ever measured, and what the server multiplies the voltages of the two outputs by; gain: counts of the recording per
    count of the converter; output_limit_v: beyond plus or minus that the card cuts off what an output shall give,
    because its offset takes a share of the converter, or because of a limit."""

    scale_v: NDArray[np.float32]
    offset_v: NDArray[np.float32]
    calibrated: bool
    output: tuple[float, float]
    gain: float
    output_limit_v: tuple[float, float] = (1.0, 1.0)

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
    numbers = np.array(values, np.float32).reshape(-1, 2)
    calibrated = int(flags) & INPUT_CALIBRATED == INPUT_CALIBRATED
    if not _plausible(numbers.astype(np.float64)):
        raise DeviceProtocolError(
            "the calibration in the card's memory makes no sense",
            where=where,
            why=", ".join(f"{key} is {value}" for key, value in zip(CALIBRATION, values, strict=True)),
            remedy="calibrate the card anew",
        )
    if not calibrated:
        log.warning("card_inputs_not_calibrated", card=where, scale_v=numbers[0].tolist())
        if table.require_calibration:
            raise DeviceProtocolError(
                "the card's inputs were never calibrated",
                where=where,
                why=f"calibration flags are {int(flags):#06b}",
                remedy="calibrate them, or set io_card.require_calibration = false",
            )
    gain = cic_gain(table.decimation)
    outputs = (float(values[4]), float(values[5]))
    limits_v = _headroom_v(numbers.astype(np.float64))
    return Scale(
        numbers[0] / np.float32(gain), numbers[1], calibrated, outputs, gain, (float(limits_v[0]), float(limits_v[1]))
    )


def _plausible(numbers: NDArray[np.float64]) -> bool:
    """Whether a card can be so: the two channels' numbers, (6, 2), in the order of CALIBRATION; false for NaN.

    The server checks none of them: a wrong scale, offset or limit of an output is a current in a coil.
    """
    full_v = 32768 * numbers[0]
    offset, scale, output_offset_v, lower_v, upper_v = numbers[1:]
    inputs = (full_v >= INPUT_FULL_SCALE_V[0]) & (full_v <= INPUT_FULL_SCALE_V[1])
    inputs &= np.abs(offset) <= INPUT_OFFSET * full_v
    outputs = (scale >= OUTPUT_SCALE[0]) & (scale <= OUTPUT_SCALE[1]) & (np.abs(output_offset_v) <= OUTPUT_OFFSET_V)
    outputs &= (lower_v < 0) & (upper_v > 0) & np.isfinite(lower_v) & np.isfinite(upper_v)
    return bool(np.all(inputs & outputs)) and bool(np.all(_headroom_v(numbers) > 0))


def _headroom_v(numbers: NDArray[np.float64]) -> NDArray[np.float64]:
    """The largest amplitude of the two outputs that the card does not cut off, V; numbers as in `_plausible`.

    The card adds an output's offset to what it plays, and then limits the sum.  To both outputs' limits the server adds
    the offset of the first one, and the converter ends at 1 V over the scale.
    """
    scale, offset_v, lower_v, upper_v = numbers[2:]
    highest_v = np.minimum(upper_v + offset_v[0], 1 / scale)
    lowest_v = np.maximum(lower_v + offset_v[0], -1 / scale)
    return np.minimum(highest_v - offset_v, offset_v - lowest_v)
