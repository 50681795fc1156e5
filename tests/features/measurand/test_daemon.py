"""A resonator that is calibrated as a sensor, while a daemon measures it."""

import math
from itertools import islice

import pytest

from platform_daemon.client import Client
from platform_daemon.core.settings import load_specimen
from tests.kit.command_line import here, wait_for
from tests.kit.pressure_sensor import barometer, pressures
from tests.kit.served import served

HIGHEST_MBAR = 1040.0
DECLARED = f"""
[measurand]
name = "pressure"
unit = "mbar"
degree = 2
reference = {{ u = 0.05 }}
highest = {HIGHEST_MBAR}
"""
PERIOD_S, SWING_MBAR = 600.0, 50.0
HOUSING = {"swing_mbar": SWING_MBAR, "period_s": PERIOD_S, "f_nat_hz_per_mbar": -0.06}


@pytest.mark.long
def test_every_shot_is_a_reading_from_the_moment_of_the_calibration_on(tmp_path):
    """Events, alarm, Prometheus and `GET` tell the pressure of the simulated housing with U."""
    data, file = tmp_path / "data", tmp_path / "reference.csv"
    shipped, text = load_specimen("jewel")
    (data / "resonators").mkdir(parents=True)
    specimen = data / "resonators" / "sensor@1.toml"
    specimen.write_text(text + DECLARED)
    sets = [x for key, value in HOUSING.items() for x in ("--set", f"backends.simulated.housing.{key}={value}")]
    sets += ["--set", "backends.simulated.effects.temperature.sd_k=0.02"]
    with served(data, *sets) as daemon, Client(daemon.address) as lab:

        def measured(shots):
            job = lab.measure("sensor", shots=shots, pause_s=PERIOD_S / shots, sequence={"rx_s": 0.6})
            return job, data / "recordings" / f"{job.wait().result.recording}.h5"

        job, calibration = measured(14)
        assert not list(lab.events(job, kinds=("measurand",)))
        file.write_text(barometer(calibration, PERIOD_S))
        done = here(
            "measurand", "calibrate", specimen, calibration, "--reference", file, "--measurands", data / "measurands"
        )
        assert done.returncode == 0, done.stderr
        (made,) = lab.measurands()
        assert made.specimen == shipped.name

        job, blind = measured(6)
        # Not those of the job alone, whose stream ends with it: the last reading may come later.
        told = [event.what for event in islice(lab.events(kinds=("measurand",), after=0), 6)]
        assert {each.job for each in told} == {job.id}
        assert [each.shot for each in told] == list(range(1, 7))
        assert {(each.specimen, each.unit, each.calibration) for each in told} == {(shipped.name, "mbar", made.label)}
        truth = dict(enumerate(pressures(blind), start=1))
        read = [each for each in told if each.value is not None]
        assert len(read) >= 4  # a shot of the highest pressure may lie beyond those of the calibration
        assert all("outside of the calibration" in each.reason for each in told if each.value is None)
        # All readings share the errors of one calibration, so that they are outside of U together or not at all.
        assert all(abs(each.value - truth[each.shot]) <= 2.0 * each.U for each in read)

        raised = lambda: [each for each in lab.alarms() if each.name == f"measurand:{shipped.name}"]  # noqa: E731 short
        wait_for(raised)  # it follows the reading
        (alarm,) = raised()
        assert "pressure" in alarm.what

        report = job.recording().measurand()
        stored = {each.frames[0] + 1: (each.value, each.U) for each in report.shots}
        assert stored == {each.shot: (pytest.approx(each.value), pytest.approx(each.U, rel=0.1)) for each in read}
        scraped = daemon.get("/metrics").text
        line = next(each for each in scraped.splitlines() if each.startswith("mmr_measurand{"))
        newest = math.nan if told[-1].value is None else told[-1].value
        assert float(line.split()[-1]) == pytest.approx(newest, nan_ok=True)
