"""Measurands: a calibration as it is kept, and readings by it."""

from __future__ import annotations

from typing import Literal

from pydantic import ConfigDict

from platform_daemon.core.schemas.base import ListPage, Schema, example
from platform_daemon.core.schemas.fits import FileDigest
from platform_daemon.core.schemas.problems import UnreadableFile
from platform_daemon.features.budget.schema import BudgetLine


class ResidualTest(Schema):
    """Something that the calibration does not contain, tested on what it leaves over."""

    value: float
    """Its size."""
    u: float
    """Standard uncertainty of it."""
    probability: float
    """Chance that makes as much where there is none."""
    significant: bool
    """The chance is below 1 %: the effect is a line of every budget."""


class CrossValidationReport(Schema):
    """Readings of stretches of time that the calibration was made without."""

    rms: float
    """Root mean square of reading minus reference, in the unit of the measurand."""
    covered: float
    """Share of readings within the interval of 95 %."""
    readings: int
    """How many."""


class ReferenceU(Schema):
    """What all readings of the reference have in common."""

    u: float
    """Standard uncertainty, in the unit of the measurand."""
    distribution: Literal["normal", "rectangular", "triangular", "arcsine"]
    """Of what it may be."""
    type: Literal["A", "B"] = "B"
    """A: evaluated from repeated observations; B: from anything else."""
    dof: float | None = None
    """Degrees of freedom of u; null: infinitely many."""
    valid_until: str | None = None
    """Last day of its certificate, ISO 8601; null: there is none, or it says none."""
    source: str
    """Where it is known from."""


class MeasurandCalibration(Schema):
    """How the natural frequency of a specimen follows a quantity; one file, never changed."""

    model_config = ConfigDict(json_schema_extra=example("measurand_calibration"))

    specimen: str
    """Name of the specimen."""
    key: str
    """Name of its file, under which versions are counted."""
    version: int
    """Number from 1."""
    name: str
    """The quantity in words."""
    unit: str
    """Its unit."""
    model: str
    """polynomial, dipole, or the name of an entry point."""
    degree: int
    """Of a polynomial; 0: the model is none."""
    centre: float
    """Of a polynomial: it is one of (x - centre) / scale, in the unit of the measurand."""
    scale: float
    """See centre."""
    parameters: dict[str, float]
    """Of the curve, f in Hz; per_k: change of f with the temperature, Hz/K."""
    covariance: tuple[tuple[float, ...], ...]
    """Of the parameters, in their order."""
    valid_from: float
    """Lowest value of the calibration, in the unit of the measurand."""
    valid_to: float
    """Highest value."""
    temperature_c: float | None
    """Temperature at which the curve holds, degrees Celsius; null: it is not corrected for it."""
    temperature_from_c: float | None
    """Lowest temperature of the calibration; null: not measured."""
    temperature_to_c: float | None
    """Highest temperature."""
    scatter_hz: float
    """Standard deviation of f from shot to shot about the curve, Hz."""
    dof: float
    """Degrees of freedom of it."""
    chi2_per_dof: float
    """Of the regression."""
    lag_s: float | None
    """The resonator follows the reference after so long, s; negative: it precedes it; null: none was allowed."""
    lag_std_s: float | None
    """Its standard deviation, s."""
    hysteresis_hz: ResidualTest
    """Half of the difference of f while the quantity rises and while it falls, Hz."""
    drift_hz_per_day: ResidualTest
    """Change of f with time, Hz per day."""
    by_temperature_hz_per_k: ResidualTest | None
    """Change of f with the temperature where it is not corrected for, Hz/K; null: it is, was not measured,
    or is the quantity itself, as the platform's thermometer has read it."""
    cross_validation: CrossValidationReport
    """What it is worth for readings that it was not made of."""
    reference: ReferenceU | None
    """What all readings of the reference have in common; null: not declared, and not contained in any U."""
    resolution: float
    """Standard deviation of one shot in the middle of the range, in the unit of the measurand."""
    pairs: int
    """Shots with a reading of the reference."""
    dropped: int
    """Shots without one, or without a fit."""
    began: str
    """Time of the first shot, ISO 8601."""
    ended: str
    """Time of the last one."""
    software_version: str
    """Of the software that made it."""
    files: tuple[FileDigest, ...]
    """Reference and recordings."""
    notes: tuple[str, ...]
    """What must be known when it is used."""

    @property
    def label(self) -> str:
        """KEY@VERSION."""
        return f"{self.key}@{self.version}"


class MeasurandReading(Schema):
    """The measurand by one shot, or by the mean of several."""

    frames: tuple[int, ...]
    """Frames of the recording, from 0."""
    at: str | None
    """When the first one was made, ISO 8601; null: the file does not say."""
    value: float
    """In the unit of the measurand."""
    u: float
    """Combined standard uncertainty of what is declared."""
    dof: float | None
    """Effective degrees of freedom; null: infinitely many."""
    k: float
    """Coverage factor."""
    U: float
    """Expanded uncertainty, k u."""
    coverage: float
    """Probability of the interval value ± U."""
    f_nat_hz: float
    """Natural frequency, Hz."""
    temperature_c: float | None
    """Temperature, degrees Celsius; null: not measured."""
    extrapolated: bool
    """Outside of the range of the calibration, or corrected for a temperature outside of those of the calibration."""
    inputs: tuple[BudgetLine, ...]
    """The inputs, the largest contribution first."""


class UnreadShot(Schema):
    """A shot without a reading."""

    frame: int
    """Its frame, from 0."""
    reason: str
    """Why."""


class MeasurandReport(Schema):
    """A recording as readings of a sensor."""

    model_config = ConfigDict(json_schema_extra=example("measurand_report"))

    file: str
    """Recording."""
    calibration: str
    """KEY@VERSION of the calibration."""
    name: str
    """The quantity in words."""
    unit: str
    """Its unit."""
    shots: tuple[MeasurandReading, ...]
    """Shot by shot."""
    mean: MeasurandReading | None
    """Of all of them; null: see mean_reason."""
    mean_reason: str | None
    """Why there is no mean; null: there is one."""
    refused: tuple[UnreadShot, ...]
    """Shots without a reading: no fit, or outside of the range."""
    not_declared: tuple[str, ...]
    """What U does not contain."""


class MeasurandListing(ListPage[MeasurandCalibration]):
    """Every version of every calibration, by key and version."""

    model_config = ConfigDict(json_schema_extra=example("measurand_calibration", listed=True))

    broken: tuple[UnreadableFile, ...] = ()
    """Files that hold none, with the reason."""
