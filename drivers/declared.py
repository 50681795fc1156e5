"""The back end `declared`: coils and calibration whose numbers stand in the platform file."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from drivers.backend import RealBackend
from drivers.calibration import ReceiveCalibration, TransmitChannel
from drivers.validation import validated

Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Row = Annotated[tuple[Finite, Finite, Finite], Field(strict=False)]

FINE_HZ, FINE_UP_TO_HZ, COARSE_HZ = 10.0, 3000.0, 50.0  # a delay bends so little that this is exact to 1e-6


class Section(BaseModel):
    """Unknown keys are errors, nothing is coerced."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class CoilTable(Section):
    """One coil axis from the DAC on: see drivers.calibration.TransmitChannel; the loop includes the amplifier."""

    output: Annotated[int, Field(ge=0)]
    amplifier_gain: Positive
    amplifier_limit_v: Positive
    resistance_ohm: Positive
    inductance_h: Positive
    field_per_ampere_t: Row


class CoilsTable(Section):
    """`[coils]`: the three axes."""

    x: CoilTable
    y: CoilTable
    z: CoilTable


class CalibrationTable(Section):
    """`[calibration]`: sensitivity V/(A m^2/s), one row per channel, columns world x, y, z, at `lna_gain`; delay_s:
    what the I/O card's filters still delay after compensation to the nearest sample, up to `frequency_max_hz`."""

    sensitivity: Annotated[tuple[Row, ...], Field(strict=False, min_length=1)]
    identifier: Annotated[str, Field(min_length=1)]
    date: datetime
    lna_gain: Positive | None = None
    delay_s: Finite = 0.0
    frequency_max_hz: Positive = 30500.0


class DeclaredBackend(RealBackend):
    """See drivers.platform.Backend; the table `[backends.declared]` is empty."""

    name = "declared"

    def __init__(self, options: Mapping[str, Any]) -> None:
        validated(Section, options, "backends.declared")

    def transmit_channels(self, options: Mapping[str, Any]) -> tuple[TransmitChannel, ...]:
        """See Backend."""
        table = validated(CoilsTable, options, "coils")
        return tuple(_channel(axis, coil) for axis, coil in (("x", table.x), ("y", table.y), ("z", table.z)))

    def receive_calibration(self, options: Mapping[str, Any]) -> ReceiveCalibration:
        """See Backend."""
        table = validated(CalibrationTable, options, "calibration")
        frequency_hz = _frequencies_hz(table.frequency_max_hz)
        response = np.tile(np.exp(-2j * np.pi * frequency_hz * table.delay_s), (len(table.sensitivity), 1))
        return ReceiveCalibration(
            sensitivity=np.array(table.sensitivity),
            identifier=table.identifier,
            date=table.date.isoformat(),
            lna_gain=table.lna_gain,
            frequency_hz=frequency_hz if table.delay_s else None,
            frequency_response=response if table.delay_s else None,
        )


def _channel(axis: str, coil: CoilTable) -> TransmitChannel:
    field = np.array(coil.field_per_ampere_t)
    return TransmitChannel(axis=axis, **{**coil.model_dump(), "field_per_ampere_t": field})


def _frequencies_hz(highest_hz: float) -> np.ndarray:
    fine = np.arange(0.0, min(FINE_UP_TO_HZ, highest_hz), FINE_HZ)
    return np.concatenate([fine, np.arange(FINE_UP_TO_HZ, highest_hz + COARSE_HZ, COARSE_HZ)])
