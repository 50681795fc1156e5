"""The calibration of a card's converters, from its EEPROM."""

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


@dataclass(frozen=True, kw_only=True)
class Scale:
    """Calibration of the two inputs and the two outputs.

    scale_v, offset_v: of the inputs, (2,) float32, V per count and V at count 0; calibrated: whether these were ever
    measured; output: factors by which the server multiplies the voltages of the outputs; gain: counts of the recording
    per count of the converter; output_limit_v: amplitude beyond which the card clips an output, because of its offset
    or of a limit in its EEPROM, V.
    """

    scale_v: NDArray[np.float32]
    offset_v: NDArray[np.float32]
    calibrated: bool
    output: tuple[float, float]
    gain: float
    output_limit_v: tuple[float, float] = (1.0, 1.0)

    def full_scale_v(self, channel: int) -> float:
        """Full scale of the converter of an input, V."""
        return 32768 * self.gain * float(self.scale_v[channel])

    def ends_v(self, channel: int) -> tuple[float, float]:
        """The voltages of the converter's lowest and highest code."""
        full_v = self.full_scale_v(channel)
        offset = float(self.offset_v[channel])
        return -full_v + offset, full_v * 32767 / 32768 + offset


def read_scale(ask: Callable[..., list[str | int | float]], table: CardTable, where: str) -> Scale:
    """Read it from the card.  Raises DeviceProtocolError if it is implausible, or absent and `table` requires it."""
    keys = [f"RP:CALIB:{what}?" for what in CALIBRATION]
    *values, flags = ask(*keys, "RP:CALIB:FLAGS")
    numbers = np.array(values, np.float32).reshape(-1, 2)
    calibrated = int(flags) & INPUT_CALIBRATED == INPUT_CALIBRATED
    if not _plausible(numbers.astype(np.float64)):
        raise DeviceProtocolError(
            "the calibration in the card's memory makes no sense",
            where=where,
            why=", ".join(f"{key} is {value}" for key, value in zip(CALIBRATION, values, strict=True)),
            remedy="calibrate the card again",
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
        scale_v=numbers[0] / np.float32(gain),
        offset_v=numbers[1],
        calibrated=calibrated,
        output=outputs,
        gain=gain,
        output_limit_v=(float(limits_v[0]), float(limits_v[1])),
    )


def _plausible(numbers: NDArray[np.float64]) -> bool:
    """Whether the numbers are plausible: (6, 2), two channels in the order of CALIBRATION; False for NaN.

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
