"""What a certificate says of a resonator as a sensor."""

from __future__ import annotations

import numpy as np

from drivers.errors import InputError
from platform_daemon.core.schemas.text import same_name
from platform_daemon.features.measurand.schema import MeasurandCalibration
from platform_daemon.features.measurand.sensor import Sensor

from .schema import SensorPart, SensorPoint, TraceabilityLine

_POINTS = 5
"""A parabola is seen, and the ends of the range are among them."""


def sensor_part(made: MeasurandCalibration, specimen: str, coverage: float) -> SensorPart:
    """Frequency and U of one shot, over the range of a calibration.

    Raises InputError for that of another specimen, and for a reference of which nobody has declared what its readings
    have in common: no number of readings makes that less, and U would be silent about it.
    """
    where = f"measurand {made.label}"
    if same_name(made.specimen) != same_name(specimen):
        what = f"it is of {made.specimen!r}, not of {specimen!r}"
        raise InputError(what, where=where, remedy="name a calibration of the specimen")
    if made.reference is None:
        what = "no certificate: nobody has declared what the readings of the reference have in common"
        remedy = "declare it as `reference` in [measurand] of the resonator's file, and calibrate again"
        raise InputError(what, where=where, remedy=remedy)
    sensor = Sensor.by(made)
    places = np.linspace(made.valid_from, made.valid_to, _POINTS)
    second = None if made.temperature_c is None else np.full(_POINTS, made.temperature_c)
    points = []
    for x, f_hz in zip(places.tolist(), sensor.curve.value(places, second).tolist(), strict=True):
        told, _ = sensor.read(f_hz, made.temperature_c, None, coverage=coverage)
        points.append(SensorPoint(value=x, f_nat_hz=f_hz, U=told.expanded, k=told.k))
    return SensorPart(
        calibration=made.label,
        name=made.name,
        unit=made.unit,
        coverage=coverage,
        temperature_c=made.temperature_c,
        temperature_from_c=made.temperature_from_c,
        temperature_to_c=made.temperature_to_c,
        calibrated_from=made.began,
        calibrated_to=made.ended,
        points=tuple(points),
        notes=made.notes,
    )


def reference_line(made: MeasurandCalibration) -> tuple[TraceabilityLine, ...]:
    """What the sensor is traced to."""
    if (known := made.reference) is None:
        return ()
    return (TraceabilityLine(name=f"reference of {made.name}", u=known.u, unit=made.unit, source=known.source),)
