"""The back end `declared`: coils and calibration whose numbers are in the platform file."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from drivers.backend import RealBackend
from drivers.calibration import ReceiveCalibration, TransmitChannel
from drivers.identity import Identity
from drivers.reference import FrequencyStandard
from drivers.validation import validated

Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Row = Annotated[tuple[Finite, Finite, Finite], Field(strict=False)]

# a delay bends so little that this is exact to 1e-6
FINE_HZ = 10.0
FINE_UP_TO_HZ = 3000.0
COARSE_HZ = 50.0


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


class StandardTable(Section):
    """`[reference_dipole] standard`: a generator that may feed it; relative_std: of its frequency."""

    frequency_hz: Positive
    relative_std: Annotated[float, Field(gt=0, lt=1)]
    source: Annotated[str, Field(min_length=1)] = "the frequency standard"

    def made(self) -> FrequencyStandard:
        """As the daemon knows it."""
        return FrequencyStandard(self.frequency_hz, self.relative_std, self.source)


class DipoleTable(Section):
    """`[reference_dipole]`: a coil that an operator puts in and turns.

    output: of the card, which feeds it; turns_area_m2: A m^2/A; resistance_ohm: of the whole loop, the output's own
    included; relative_std: of the moment; direction_std_rad: of its direction about each of the two axes across.
    """

    output: Annotated[int, Field(ge=0)]
    turns_area_m2: Positive
    resistance_ohm: Positive
    inductance_h: Annotated[float, Field(ge=0, allow_inf_nan=False)]
    relative_std: Annotated[float, Field(ge=0, lt=1)]
    direction_std_rad: Annotated[float, Field(gt=0, lt=1)] | None = None
    standard: StandardTable | None = None
    name: str = "reference dipole"


class DeclaredDipole:
    """See drivers.reference.ReferenceDipole."""

    def __init__(self, table: DipoleTable) -> None:
        self._table = table

    def identity(self) -> Identity:
        """See ReferenceDipole."""
        return Identity("declared", self._table.name)

    def output(self) -> int:
        """See ReferenceDipole."""
        return self._table.output

    def moment_per_volt_am2(self, frequency_hz: float) -> complex:
        """See ReferenceDipole."""
        loop_ohm = complex(self._table.resistance_ohm, 2 * np.pi * frequency_hz * self._table.inductance_h)
        return self._table.turns_area_m2 / loop_ohm

    def relative_std(self) -> float:
        """See ReferenceDipole."""
        return self._table.relative_std

    def direction_std_rad(self) -> float | None:
        """See ReferenceDipole."""
        return self._table.direction_std_rad

    def standard(self) -> FrequencyStandard | None:
        """See ReferenceDipole."""
        return None if self._table.standard is None else self._table.standard.made()

    def feed_from_standard(self) -> bool:
        """See ReferenceDipole: the operator does it."""
        return False

    def turn(self, axis: str) -> bool:
        """See ReferenceDipole: the operator does it."""
        return False

    def remove(self) -> None:
        """See ReferenceDipole."""


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

    def reference_dipole(self, options: Mapping[str, Any]) -> DeclaredDipole:
        """See Backend."""
        return DeclaredDipole(validated(DipoleTable, options, "reference_dipole"))


def _channel(axis: str, coil: CoilTable) -> TransmitChannel:
    field = np.array(coil.field_per_ampere_t)
    return TransmitChannel(axis=axis, **{**coil.model_dump(), "field_per_ampere_t": field})


def _frequencies_hz(highest_hz: float) -> np.ndarray:
    fine = np.arange(0.0, min(FINE_UP_TO_HZ, highest_hz), FINE_HZ)
    return np.concatenate([fine, np.arange(FINE_UP_TO_HZ, highest_hz + COARSE_HZ, COARSE_HZ)])
