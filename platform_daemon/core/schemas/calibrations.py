"""What calibrations of the receive and the transmit side have found, and which are in use."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from .base import Absent, Interval, Root, Schema, Vector, example

Matrix = tuple[Vector, ...]
Cube = tuple[tuple[tuple[float, ...], ...], ...]


class ComplexTable(Schema):
    """A measured complex table in the unit of its key; all three have the same shape."""

    real: Cube
    """Real part."""
    imag: Cube
    """Imaginary part."""
    std: Cube
    """Standard deviation of each of the two."""


class _Written(Schema):
    calibration: str
    """Identifier, NAME@VERSION_DATE."""
    file: str
    """Name of its file."""


class _Validity(Schema):
    date: str
    """When it was made, ISO 8601."""
    temperature_c: float | None
    """Mean temperature of its shots, degrees Celsius; null: it is not measured."""
    valid_hz: Interval
    """Between which frequencies it holds, Hz."""
    valid_c: Interval | None
    """Between which temperatures it holds, degrees Celsius; null: not said."""
    warnings: Absent[tuple[str, ...]] = None
    """What may make it wrong; written on the command line, a job has `warnings` of its own."""


class InfluenceReport(Schema):
    """How well a calibration knows an influence on later results."""

    name: str
    """As budgets print it."""
    u: float
    """Standard uncertainty: of a gain relative, of a phase or an angle rad."""
    type: Literal["A", "B"]
    """A: evaluated from repeated observations; B: from anything else."""
    dof: float | None
    """Degrees of freedom of u; null: infinitely many."""
    source: str
    """Where it is known from."""


class _Receive(_Written):
    kind: Literal["receive"]
    """The receive side."""
    dipole: str
    """Model of the reference dipole."""
    lna_gain: float
    """Gain of the low-noise amplifier at which it holds, V/V."""
    frequency_hz: tuple[float, ...]
    """Frequencies as the card played them, Hz, (k,)."""
    p_t_per_a: ComplexTable
    """P, voltage per dm/dt, by channel, axis and frequency, V/(A m^2/s) = T/A, (channels, 3, k)."""
    relative_std: float
    """Standard uncertainty of all of P together, from the reference dipole's own, relative."""
    sensitivity_t_per_a: Matrix
    """P without the frequency response, T/A, (channels, 3)."""
    sensitivity_std_t_per_a: Matrix
    """Its standard deviation, the dipole's included, T/A, (channels, 3)."""
    chi2_per_dof: float
    """How well one frequency response per channel explains P; 1: as well as the noise lets it."""
    uncertainty: Absent[tuple[InfluenceReport, ...]] = None
    """What budgets take from it where `[uncertainty]` declares nothing, beside noise and dipole; missing: an earlier
    version wrote it."""


class ReceiveCalibrationReport(_Validity, _Receive):
    """What a calibration of the receive side has found (paper eq:u(t,p,R))."""

    model_config = ConfigDict(json_schema_extra=example("receive_calibration_report"))


class _Transmit(_Written):
    kind: Literal["transmit"]
    """The transmit side."""
    probe: str
    """Model of the field probe."""
    coils: tuple[str, ...]
    """Coils in the order of all that follows."""
    frequency_hz: tuple[float, ...]
    """Frequencies as the card played them, Hz, (k,)."""
    field_t_per_v: ComplexTable
    """Field at the rotor per volt of the DAC by coil, axis and frequency, T/V, (coils, 3, k)."""
    relative_std: float
    """Standard uncertainty of all of it together, from the probe's own, relative."""
    field_t_per_a: Matrix
    """Field per ampere by coil, T/A, (coils, 3)."""
    inductance_h: tuple[float, ...]
    """Inductance by coil, H, (coils,)."""
    chi2_per_dof: tuple[float, ...]
    """How well resistance and inductance explain the field, by coil; 1: as well as the noise lets them."""


class TransmitCalibrationReport(_Validity, _Transmit):
    """What a calibration of the transmit side has found."""

    model_config = ConfigDict(json_schema_extra=example("transmit_calibration_report"))


AnyCalibrationReport = Annotated[ReceiveCalibrationReport | TransmitCalibrationReport, Field(discriminator="kind")]


class CalibrationReport(Root[AnyCalibrationReport]):
    """What a calibration has found."""

    model_config = ConfigDict(json_schema_extra=example("receive_calibration_report", "transmit_calibration_report"))


class CalibrationName(Schema):
    """Name and date of a calibration."""

    id: str
    """NAME@VERSION_DATE, or what its file says."""
    date: str
    """When it was made, ISO 8601."""


class CalibrationsInUse(Schema):
    """The calibrations that the next series is made with."""

    model_config = ConfigDict(json_schema_extra=example("calibrations_in_use"))

    calibration: CalibrationName
    """Of the receive side."""
    transmit_calibration: CalibrationName | None
    """Of the transmit side; null: coils as the platform file declares them."""
