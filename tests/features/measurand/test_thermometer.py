"""The platform's own thermometer as the reference, and which shots have a reading of a reference."""

import numpy as np
import pytest

from drivers.errors import InputError
from drivers.specimen import Measurand
from platform_daemon.features.measurand.reference_file import Reference
from platform_daemon.features.measurand.shots import Shots
from platform_daemon.features.measurand.thermometer import thermometer_readings
from platform_daemon.features.measurand.work import calibrated
from tests.kit.pressure_sensor import PRESSURE, START_S

TEMPERATURE = Measurand(name="temperature", unit="degC")
PER_K_HZ = -0.23


def shots_in_nights(celsius):
    """Five shots within a minute, every hour."""
    count = len(celsius)
    times = START_S + 3600.0 * (np.arange(count) // 5) + 10.0 * (np.arange(count) % 5)
    f = 213.0 + PER_K_HZ * (celsius - 22.0) + 1e-3 * np.random.default_rng(1).standard_normal(count)
    return Shots(
        frames=tuple(range(count)), times_s=times, f_hz=f, std_hz=np.full(count, 1e-4), celsius=celsius, refused=()
    )  # fmt: skip


def test_every_shot_with_a_reading_of_the_thermometer_is_a_pair():
    celsius = np.random.default_rng(2).uniform(20.0, 24.0, 40)
    shots = shots_in_nights(celsius)
    shots.celsius[5] = np.nan  # the first of the second hour, which nothing is interpolated for
    made = calibrated("S", TEMPERATURE, shots, thermometer_readings(shots, TEMPERATURE, "S"), 1)
    assert (made.pairs, made.dropped) == (39, 1)
    assert made.parameters["p1"] / made.scale == pytest.approx(PER_K_HZ, abs=1e-3)


@pytest.mark.parametrize(
    ("measurand", "celsius", "said"),
    [
        (PRESSURE, [20.0, 21.0], r"no reading of pressure in mbar is known.*temperature in degC.*--reference FILE.csv"),
        (TEMPERATURE.model_copy(update={"unit": "K"}), [20.0, 21.0], "no reading of temperature in K is known"),
        (TEMPERATURE.model_copy(update={"corrected_for": "temperature"}), [20.0, 21.0], "cannot correct it"),
        (TEMPERATURE, [20.0, np.nan], r"was not measured.*with a reading: 1 shot"),
    ],
)
def test_what_the_thermometer_cannot_be_the_reference_of(measurand, celsius, said):
    with pytest.raises(InputError, match=said):
        thermometer_readings(shots_in_nights(np.array(celsius)), measurand, "S")


def test_a_time_of_a_reading_is_covered_and_one_in_a_gap_is_not():
    reference = Reference(np.array([0.0, 1.0, 2.0, 100.0, 101.0]), np.zeros(5), np.zeros(5))
    times = np.array([-1.0, 0.0, 0.5, 2.0, 50.0, 100.0, 101.0, 102.0])
    assert reference.covered(times).tolist() == [False, True, True, True, False, True, True, False]
