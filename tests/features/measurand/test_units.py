"""Readings of a reference in another unit than their heading says, as far as numbers can show it."""

import numpy as np
import pytest

from drivers.errors import InputError
from drivers.specimen import Measurand
from platform_daemon.features.measurand.library import Measurands
from platform_daemon.features.measurand.plausible import refuse_other_unit
from platform_daemon.features.measurand.reference_file import Reference
from platform_daemon.features.measurand.shots import Shots
from platform_daemon.features.measurand.work import calibrated
from tests.kit.pressure_sensor import PRESSURE, START_S, PressureSensor


@pytest.mark.parametrize(
    ("unit", "given", "seems"),
    [("degC", lambda c: 1.8 * c + 32.0, "degF"), ("°C", lambda c: c + 273.15, "K"), ("K", lambda c: c, "degC")],
)
def test_a_temperature_of_another_unit_than_its_heading_says(unit, given, seems):
    sensor = PressureSensor(8)
    shots, _ = sensor.shots(START_S, 50, 900.0)
    declared = Measurand(name="temperature", unit=unit)
    readings = Reference(shots.times_s, given(shots.celsius), np.full(50, 0.02))
    with pytest.raises(InputError, match=rf"in {seems}, it seems, and not in {unit}\..*degC\. Remedy: convert"):
        calibrated("sensor", declared, shots, readings, 1)


def _scaled(reference, factor):
    return Reference(reference.times_s, factor * reference.values, factor * reference.u)


def _pressure(unit, **limits):
    return PRESSURE.model_copy(update={"unit": unit, "reference": None, **limits})


@pytest.mark.parametrize(
    ("unit", "factor", "seems"),
    [
        ("Pa", 1.0, "hPa or mbar or cmH2O"),
        ("kPa", 1.0, "hPa or mbar or cmH2O"),
        ("mbar", 100.0, "Pa"),
        ("hPa", 1e-3, "bar or atm"),
        ("mbar", 0.75006, ""),
    ],
)
def test_a_pressure_of_the_air_in_another_unit(unit, factor, seems):
    sensor = PressureSensor(8)
    shots, _ = sensor.shots(START_S, 100, 900.0)
    readings = _scaled(sensor.reference(START_S, START_S + 90e3), factor)
    if not seems:  # Torr: 730 to 780 mbar is the pressure of the air on a mountain
        assert calibrated("sensor", _pressure(unit), shots, readings, 1).pairs == 100
        return
    with pytest.raises(InputError, match=rf"in {seems}, it seems, and not in {unit}\. .* air\. Remedy: convert"):
        calibrated("sensor", _pressure(unit), shots, readings, 1)
    low, high = float(readings.values.min()) - 1.0, float(readings.values.max()) + 1.0
    with pytest.raises(InputError, match="expected_from and expected_to"):  # limits of an alarm say nothing of that
        calibrated("sensor", _pressure(unit, lowest=low, highest=high), shots, readings, 1)
    meant = _pressure(unit, expected_from=low, expected_to=high)
    assert calibrated("sensor", meant, shots, readings, 1).unit == unit


def test_a_vacuum_and_a_compressor_are_no_air():
    for unit, low, high in (("Pa", 1.0, 100.0), ("bar", 1.0, 8.0), ("Pa", 9e4, 2e5), ("mbar", 0.0, 2000.0)):
        refuse_other_unit(_pressure(unit), np.linspace(low, high, 20), np.full(20, np.nan), "it")
    blood = Measurand(name="blood pressure", unit="mmHg")
    refuse_other_unit(blood, np.linspace(60.0, 105.0, 20), np.full(20, np.nan), "it")


def test_one_reading_that_is_wrong_hides_no_unit_and_neither_do_other_letters():
    values = np.array([0.0, *np.linspace(94e3, 96e3, 19)])
    for unit in ("mbar", "torr", "Bar"):
        with pytest.raises(InputError, match="in Pa, it seems"):
            refuse_other_unit(_pressure(unit), values, np.full(20, np.nan), "it")


def test_readings_of_which_none_is_expected():
    distance = Measurand(name="distance", unit="m", model="dipole", expected_from=0.001, expected_to=0.05)
    with pytest.raises(InputError, match=r"reads 2 to 9 m, expected are 0.001 to 0.05.*check the unit"):
        refuse_other_unit(distance, np.linspace(2.0, 9.0, 20), np.full(20, np.nan), "it")
    refuse_other_unit(distance, np.linspace(0.04, 9.0, 20), np.full(20, np.nan), "it")


@pytest.mark.parametrize(("factor", "refused"), [(1000.0, True), (0.01, True), (1.5, False), (1.0, False)])
def test_readings_in_another_unit_than_those_of_the_calibration_before(factor, refused):
    """Of a field, of which nobody knows how large it is."""
    sensor = PressureSensor(8)
    declared = PRESSURE.model_copy(update={"name": "field", "unit": "uT", "reference": None})
    before_shots, _ = sensor.shots(START_S, 200, 900.0)
    before = calibrated("sensor", declared, before_shots, sensor.reference(START_S, START_S + 180e3), 1)
    shots, _ = sensor.shots(START_S + 200e3, 100, 900.0)
    readings = _scaled(sensor.reference(START_S + 200e3, START_S + 290e3), factor)
    if refused:
        with pytest.raises(InputError, match=rf"{factor:g} times what sensor@1 reads.*convert them; if they are right"):
            calibrated("sensor", declared, shots, readings, 2, before=before)
    else:
        assert calibrated("sensor", declared, shots, readings, 2, before=before).version == 2
    meant = declared.model_copy(update={"expected_from": -1e9, "expected_to": 1e9})
    assert calibrated("sensor", meant, shots, readings, 2, before=before).version == 2
    for change in ({"unit": "mT"}, {"name": "current"}, {"model": "gone"}):
        other = before.model_copy(update=change)
        assert calibrated("sensor", declared, shots, readings, 2, before=other).version == 2


def test_a_gauge_pressure_about_zero_is_held_against_the_calibration_before_in_whatever_unit():
    sensor = PressureSensor(8)
    declared = PRESSURE.model_copy(update={"name": "gauge pressure", "reference": None})

    def readings(begin_s, end_s, factor):
        found = sensor.reference(begin_s, end_s)
        return Reference(found.times_s, factor * (found.values - 1000.0), factor * found.u)

    before_shots, _ = sensor.shots(START_S, 200, 900.0)
    before = calibrated("sensor", declared, before_shots, readings(START_S, START_S + 180e3, 1.0), 1)
    shots, _ = sensor.shots(START_S + 200e3, 100, 900.0)
    wrong = readings(START_S + 200e3, START_S + 290e3, 100.0)
    with pytest.raises(InputError, match="100 times what sensor@1 reads"):
        calibrated("sensor", declared, shots, wrong, 2, before=before)
    in_pa = declared.model_copy(update={"unit": "Pa"})
    assert calibrated("sensor", in_pa, shots, wrong, 2, before=before).unit == "Pa"
    with pytest.raises(InputError, match=r"0\.01 times what sensor@1 reads"):
        calibrated("sensor", in_pa, shots, readings(START_S + 200e3, START_S + 290e3, 1.0), 2, before=before)


@pytest.mark.parametrize(("low", "high"), [(2.0, 8.0), (10.0, 12.0), (20.0, 20.5)])
def test_a_dipole_over_two_days_and_a_wide_range_is_calibrated_and_kept(low, high, tmp_path):
    """Shifted by hours, its pairs lie beyond the pole of the curve; and so does half a range below it."""
    random = np.random.default_rng(3)
    times = START_S + 900.0 * np.arange(200)

    def distance(at):
        return 0.5 * (low + high) + 0.5 * (high - low) * np.sin(2.0 * np.pi * (at - START_S) / 86400.0)

    f = 300.0 * (distance(times) + 1.0) ** -1.5
    shots = Shots(
        frames=tuple(range(200)), times_s=times, f_hz=f * (1.0 + 1e-5 * random.standard_normal(200)),
        std_hz=np.full(200, 1e-6), celsius=np.full(200, np.nan), refused=(),
    )  # fmt: skip
    read = np.arange(times[0] - 600.0, times[-1] + 600.0, 60.0)
    reference = Reference(read, distance(read), np.full(len(read), 1e-6))
    made = calibrated("sensor", Measurand(name="distance", unit="mm", model="dipole"), shots, reference, 1)
    assert made.cross_validation.covered > 0.8
    assert Measurands(tmp_path).add(made).version == 1


@pytest.mark.long
def test_what_zones_are_refused_by_chance_and_found():
    """The study of BETTER: right references, and those whose clock is off by whole hours."""
    random = np.random.default_rng(42)
    refused, tried = {True: 0, False: 0}, {True: 0, False: 0}
    for seed in range(200):
        right = seed % 2 == 0
        sensor, pairs = PressureSensor(seed), int(random.integers(20, 201))
        hours = 0 if right else int(random.choice([-1, 1])) * int(random.integers(1, 13))
        shots, _ = sensor.shots(START_S, pairs, 900.0)
        whole = sensor.reference(START_S - 14 * 3600.0, START_S + 900.0 * pairs + 14 * 3600.0)
        readings = Reference(whole.times_s + 3600.0 * hours, whole.values, whole.u)
        if not right and 900.0 * pairs < 3.0 * 3600.0 * abs(hours) + 900.0:  # slow changes look alike over less
            continue
        tried[right] += 1
        try:
            calibrated("sensor", PRESSURE.model_copy(update={"reference": None}), shots, readings, 1)
        except InputError as error:
            refused[right] += "the times of the reference are wrong" in str(error)
    print(f"refused {refused[True]} of {tried[True]} right, {refused[False]} of {tried[False]} wrong ones")
    assert refused[True] == 0
    assert refused[False] > 0.9 * tried[False]
