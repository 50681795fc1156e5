"""The platform's own thermometer as the reference of a resonator that is to be a sensor of the temperature."""

from __future__ import annotations

import numpy as np

from drivers.errors import InputError
from drivers.specimen import Measurand
from platform_daemon.core.schemas.text import counted

from .reference_file import Reference
from .shots import Shots

_QUANTITY, _UNITS = "temperature", ("degC", "°C")
NOTE = (
    "the reference is the thermometer of the platform as it was read with each shot; nothing says by how much a reading"
    " scatters, which makes the curve less steep: give readings with their uncertainty if that matters"
)


def thermometer_readings(shots: Shots, measurand: Measurand, where: str) -> Reference:
    """What the thermometer read with each shot: of all quantities that alone is in every recording.

    where: as messages name what is calibrated.  Raises InputError for a measurand that is not the temperature in
    degrees Celsius, one that is corrected for it, has a lag or a reference of its own, and fewer than two shots with a
    reading.
    """
    if measurand.name.casefold() != _QUANTITY or measurand.unit not in _UNITS:
        what = f"no reading of {measurand.name} in {measurand.unit} is known"
        why = f"a recording holds the {_QUANTITY} in {_UNITS[0]}, and no other quantity"
        remedy = "give readings of a reference: --reference FILE.csv, over REST `reference`"
        raise InputError(what, where=where, why=why, remedy=remedy)
    if measurand.corrected_for is not None:
        remedy = "leave corrected_for out, or give readings of another thermometer: --reference FILE.csv"
        raise InputError("the temperature is the quantity, and cannot correct it", where=where, remedy=remedy)
    if measurand.reference is not None:
        what, why = "the readings of the reference are missing", f"U rests on {measurand.reference.source!r}"
        remedy = (
            "give them: --reference FILE.csv; or leave [measurand] reference out, and the platform's thermometer is it"
        )
        raise InputError(what, where=where, why=why, remedy=remedy)
    if measurand.longest_lag_s > 0.0:
        what, why = "the thermometer of the platform tells no lag", "it is read with each shot, and not between them"
        remedy = "leave longest_lag_s out, or give readings of another thermometer: --reference FILE.csv"
        raise InputError(what, where=where, why=why, remedy=remedy)
    read = np.isfinite(shots.celsius)
    if read.sum() < 2:
        what, remedy = "the temperature was not measured", "record with a thermometer, or give --reference FILE.csv"
        raise InputError(what, where=where, why=f"with a reading: {counted(int(read.sum()), 'shot')}", remedy=remedy)
    return Reference(shots.times_s[read], shots.celsius[read], np.zeros(int(read.sum())))
