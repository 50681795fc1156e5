"""A certificate as JSON."""

from __future__ import annotations

from platform_daemon.core.schemas.base import Absent, Schema
from platform_daemon.core.schemas.fits import FileDigest
from platform_daemon.features.budget.schema import BudgetReport


class CertificateContact(Schema):
    """A laboratory or a customer."""

    name: str
    """Its name."""
    city: str
    """Where it is."""
    country: str
    """Country, two letters (ISO 3166-1)."""


class TraceabilityLine(Schema):
    """An input of the results and where it is known from."""

    name: str
    """Of the input, in words."""
    u: float
    """Standard uncertainty, in `unit`."""
    unit: str
    """Of the input; 1: it is relative."""
    source: str
    """Instrument, certificate or observation."""


class SensorPoint(Schema):
    """What one shot of a sensor is good for, at one place of its range."""

    value: float
    """In the unit of the measurand."""
    f_nat_hz: float
    """Natural frequency there, Hz, at the temperature of the curve."""
    U: float
    """Expanded uncertainty of the measurand by one shot, in its unit."""
    k: float
    """Coverage factor."""


class SensorPart(Schema):
    """The calibration of the resonator as a sensor."""

    calibration: str
    """KEY@VERSION."""
    name: str
    """The quantity in words."""
    unit: str
    """Its unit."""
    coverage: float
    """Probability with which value ± U covers the quantity."""
    temperature_c: float | None
    """Temperature of the curve, degrees Celsius; null: it is not corrected for it."""
    temperature_from_c: float | None
    """Lowest temperature that it holds for, degrees Celsius; null: not measured."""
    temperature_to_c: float | None
    """Highest one."""
    calibrated_from: str
    """When the calibration began, ISO 8601."""
    calibrated_to: str
    """When it ended, ISO 8601."""
    points: tuple[SensorPoint, ...]
    """From the lowest to the highest value that it holds for."""
    notes: tuple[str, ...]
    """What must be known when it is used."""


class CertificateReport(Schema):
    """A calibration certificate."""

    number: str
    """Its number."""
    issued: str
    """Date of issue, ISO 8601."""
    laboratory: CertificateContact
    """Who issues it."""
    customer: CertificateContact
    """To whom."""
    person: str
    """Who is responsible, and signs."""
    item: str
    """Name of the resonator."""
    sample: str
    """Identification of the specimen; "": the recordings name none."""
    variant: str
    """Its bearing."""
    method: tuple[str, ...]
    """How the values were found, with the version of the software."""
    measured_from: str
    """Day of the first shot, ISO 8601."""
    measured_to: str
    """Day of the last shot."""
    temperature_c: float | None
    """Mean temperature, to which the values belong, degrees Celsius; null: not measured."""
    shots: int
    """Shots that the values are the mean of."""
    traceability: tuple[TraceabilityLine, ...]
    """The inputs of type B, and the calibration."""
    results: tuple[BudgetReport, ...]
    """The values with their budgets."""
    sensor: Absent[SensorPart] = None
    """Of a resonator that is calibrated as a sensor; missing: none was asked for."""
    cone_rad: float | None
    """Half angle of the cone that contains a direction fixed to the rotor, at the coverage, rad; null: none."""
    valid_until: str | None
    """First day on which a certificate of an input expires, ISO 8601; null: none of them says one."""
    accepted_misfit: Absent[str] = None
    """The model leaves more than noise: by how much, by whom that is accepted, and why; missing: it leaves noise."""
    not_contained: tuple[str, ...]
    """Influences that U does not contain, with what they add per unit."""
    files: tuple[FileDigest, ...]
    """Recordings, and what the calibration of a sensor was made of."""
