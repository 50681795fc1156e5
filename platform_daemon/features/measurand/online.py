"""Readings of resonators that are calibrated as sensors, shot by shot while they are measured."""

from __future__ import annotations

import time
from collections.abc import Callable
from datetime import datetime
from functools import lru_cache
from pathlib import Path

from drivers.errors import PlatformError
from drivers.specimen import Measurand, Specimen
from platform_daemon.core.hardware.catalogue import Catalogue
from platform_daemon.core.jobs.events import EventSink
from platform_daemon.core.schemas.acquisitions import ShotPage, ShotReading, ShotReport
from platform_daemon.core.schemas.events import AnyEvent, FitEvent, MeasurandEvent
from platform_daemon.core.schemas.text import same_name

from .library import Measurands
from .schema import MeasurandCalibration


class NewestCalibrations:
    """The newest calibration of each specimen in a folder, which is read again when a file has come or gone."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._seen_ns = -1
        self._newest: dict[str, MeasurandCalibration] = {}

    def of(self, specimen: str) -> MeasurandCalibration | None:
        """By the name of the specimen; None: it has none."""
        try:
            changed_ns = self._folder.stat().st_mtime_ns
        except OSError:  # nothing has been calibrated yet
            return None
        if changed_ns != self._seen_ns:
            ordered = sorted(Measurands(self._folder).all()[0], key=lambda each: (each.ended, each.version))
            self._newest = {same_name(each.specimen): each for each in ordered}
            self._seen_ns = changed_ns
        return self._newest.get(same_name(specimen))


@lru_cache(maxsize=4)
def newest_calibrations(folder: Path) -> NewestCalibrations:
    """Of a folder, for all who ask."""
    return NewestCalibrations(folder)


def reading_of(
    made: MeasurandCalibration, f_hz: float, celsius: float | None, at_s: float | None, *, shots: int = 1
) -> ShotReading:
    """What a natural frequency, Hz, reads, or the mean of several shots; where nothing can be read, the reason.

    celsius: temperature, degrees Celsius; at_s: when, s since 1970; None: not known.
    """
    from .sensor import Sensor  # scipy, which a daemon without sensors does not need

    value = expanded = reason = None
    try:
        found, _ = Sensor.by(made).read(f_hz, celsius, at_s, shots=shots)
    except PlatformError as error:
        reason = str(error)
    else:
        value, expanded = found.value, found.expanded
    return ShotReading(name=made.name, unit=made.unit, calibration=made.label, value=value, U=expanded, reason=reason)


def with_readings(page: ShotPage, specimen: str, calibrations: NewestCalibrations) -> ShotPage:
    """The shots of a specimen, each that has a good fit with what it reads; as they are if it is no sensor."""
    made = calibrations.of(specimen)
    if made is None:
        return page

    def read(shot: ShotReport) -> ShotReport:
        if shot.fit is None or not shot.fit.good:
            return shot
        at_s = None if shot.time_stamp is None else datetime.fromisoformat(shot.time_stamp).timestamp()
        found = reading_of(made, shot.fit.parameters["f_nat_hz"].value, shot.temperature_c, at_s)
        return shot.model_copy(update={"measurand": found})

    return page.model_copy(update={"items": tuple(map(read, page.items))})


class OnlineReadings:
    """Makes an event of each on-line fit of a resonator that has a calibration.

    folder: of the calibrations; catalogue: of the resonators, whose files declare the limits; tell: takes the events;
    now_s: time of day, s since 1970.
    """

    def __init__(
        self, folder: Path, catalogue: Catalogue, tell: EventSink, now_s: Callable[[], float] = time.time
    ) -> None:
        self._calibrations = NewestCalibrations(folder)
        self._catalogue, self._tell, self._now_s = catalogue, tell, now_s

    def see(self, what: AnyEvent) -> None:
        """Read a good fit."""
        if isinstance(what, FitEvent) and what.specimen is not None and what.f_nat_hz is not None:
            made = self._calibrations.of(what.specimen)
            if made is not None:
                self._tell(self._reading(what, what.f_nat_hz, made))

    def _reading(self, fit: FitEvent, f_hz: float, made: MeasurandCalibration) -> MeasurandEvent:
        limits = self._limits(made.specimen)
        found = reading_of(made, f_hz, fit.temperature_c, self._now_s())
        within: bool | None = None
        if limits is not None:
            within = False
            if found.value is not None and found.U is not None:
                within = is_within(found.value, found.U, limits)
        return MeasurandEvent(job=fit.job, shot=fit.shot, specimen=made.specimen, within=within, **found.model_dump())

    def _limits(self, specimen: str) -> Measurand | None:
        """What declares limits of its readings: of resonators with that name the newest that declares any."""
        newest = [each for key, each in self._catalogue.resonators.all().items() if "@" not in key]
        known = [
            each.measurand
            for each in newest
            if isinstance(each, Specimen) and same_name(each.name) == same_name(specimen)
        ]
        limited = [each for each in known if each is not None and (each.lowest, each.highest) != (None, None)]
        return limited[-1] if limited else None


def is_within(value: float, expanded: float, limits: Measurand) -> bool | None:
    """Whether value ± U lies within the limits; None: one of them lies in the interval, so that nobody can tell."""
    low, high = value - expanded, value + expanded
    if (limits.lowest is not None and high < limits.lowest) or (limits.highest is not None and low > limits.highest):
        return False
    inside = (limits.lowest is None or low >= limits.lowest) and (limits.highest is None or high <= limits.highest)
    return True if inside else None
