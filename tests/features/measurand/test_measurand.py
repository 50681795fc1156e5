"""Resonators as sensors: calibrated against a noisy reference with lag, read blind, and what is refused."""

import json
import re
from dataclasses import replace
from datetime import date

import numpy as np
import pytest

from drivers.errors import InputError
from drivers.specimen import Measurand
from drivers.uncertainty import Certificate, Influence
from platform_daemon.core.settings import load_specimen
from platform_daemon.features.measurand.library import Measurands
from platform_daemon.features.measurand.plausible import refuse_other_unit
from platform_daemon.features.measurand.reference_file import Reference, read_reference, reference_from
from platform_daemon.features.measurand.report import readings_text
from platform_daemon.features.measurand.schema import UnreadShot
from platform_daemon.features.measurand.sensor import Sensor, report_of
from platform_daemon.features.measurand.shots import Shots
from platform_daemon.features.measurand.work import calibrated, key_of
from tests.kit.command_line import assert_one_line_error, here
from tests.kit.pressure_sensor import (
    DAY_S,
    PRESSURE,
    SCATTER_HZ,
    START_S,
    PressureSensor,
    barometer,
    pressures,
)


def pressure_campaign(seed, readings):
    """Calibrate for two days, and read blind for a week: which readings are covered, and their resolution."""
    sensor = PressureSensor(seed)
    shots, _ = sensor.shots(START_S, 200, 900.0)
    reference = sensor.reference(START_S, START_S + 200 * 900.0)
    made = calibrated("a pressure sensor", PRESSURE, shots, reference, 1)
    week, mbar = sensor.shots(START_S + 3.0 * DAY_S, readings, 6.0 * DAY_S / readings)
    inside = (mbar > made.valid_from) & (mbar < made.valid_to)
    report = report_of("blind", week, made)
    told = {reading.frames[0]: reading for reading in report.shots}
    hits = [abs(told[k].value - mbar[k]) <= told[k].U for k in range(readings) if k in told and inside[k]]
    return hits, made, report


def temperature_campaign(seed, readings):
    """The same of a temperature sensor that follows the thermometer with a time constant of 300 s."""
    random = np.random.default_rng(seed)
    lag_s, offset_k = 300.0, 0.004 * random.standard_normal()  # less than the scatter: a hundred draws are few
    times = np.arange(START_S, START_S + 8.0 * DAY_S, 60.0)
    hours = (times - START_S) / 3600.0
    phases = random.uniform(0.0, 2.0 * np.pi, 2)
    celsius = 22.0 + 3.0 * np.sin(hours / 4.0 + phases[0]) + np.sin(hours / 0.7 + phases[1])
    thermometer = Reference(times, celsius, np.full(len(times), 1e-9))
    inside, _ = thermometer.at(times, lag_s)
    noise = 0.02 * random.standard_normal(len(times))
    reference = Reference(times, celsius + offset_k + noise, np.full(len(times), 0.02))

    def shots(places):
        f = 213.0 - 0.23 * (inside[places] - 22.0) + 0.002 * random.standard_normal(len(places))
        nothing = np.full(len(places), np.nan)
        return Shots(
            frames=tuple(range(len(places))),
            times_s=times[places],
            f_hz=f,
            std_hz=np.full(len(places), 1e-4),
            celsius=nothing,
            refused=(),
        )

    declared = Measurand(name="temperature", unit="degC", longest_lag_s=1500.0, reference={"u": 0.004})
    made = calibrated("a temperature sensor", declared, shots(np.arange(60, 2 * 1440, 15)), reference, 1)
    week = np.sort(random.choice(np.arange(2 * 1440, 8 * 1440 - 1), readings, replace=False))
    report = report_of("blind", shots(week), made)
    hits = [abs(each.value - inside[week[each.frames[0]]]) <= each.U for each in report.shots]
    return hits, made, report


def test_a_pressure_sensor_is_calibrated_and_read_blind():
    hits, made, report = pressure_campaign(1, 60)
    assert np.mean(hits) >= 0.85
    assert made.resolution == pytest.approx(SCATTER_HZ / 0.06, rel=0.2)
    assert made.cross_validation.covered > 0.9
    assert made.parameters["per_k"] == pytest.approx(-0.23, abs=0.01)
    assert not made.hysteresis_hz.significant
    assert report.shots[0].inputs[0].name == "scatter"
    mean = report.mean
    assert {line.name for line in mean.inputs} >= {"scatter", "reference", "calibration"}
    assert mean.U < report.shots[0].U
    assert mean.U > 1.96 * 0.05  # what all readings of the reference have in common is not made less by a mean


def test_a_temperature_sensor_finds_its_lag():
    hits, made, _ = temperature_campaign(2, 60)
    assert made.lag_s == pytest.approx(300.0, abs=4.0 * made.lag_std_s)
    assert made.lag_std_s < 30.0
    assert np.mean(hits) >= 0.85


@pytest.mark.long
def test_coverage_of_blind_weeks():
    """U covers in 93 to 97 %: pressure and temperature sensors, each with its own calibration and a week."""
    for campaign in (pressure_campaign, temperature_campaign):
        hits, resolution = [], []
        for seed in range(30):
            found, made, _ = campaign(seed, 100)
            hits += found
            resolution.append(made.resolution)
        print(campaign.__name__, np.mean(hits), len(hits), np.mean(resolution))
        assert 0.93 <= np.mean(hits) <= 0.97


@pytest.fixture(scope="module")
def sensor():
    shots, _ = PressureSensor(3).shots(START_S, 200, 900.0)
    return calibrated("sensor", PRESSURE, shots, PressureSensor(3).reference(START_S, START_S + 180e3), 1)


def test_extrapolation_is_refused_unless_asked_for(sensor):
    reader = Sensor.by(sensor)
    far = PressureSensor(0).f_hz(sensor.valid_to + 20.0, 22.0)
    with pytest.raises(InputError, match=r"outside of the calibration.*--extrapolate"):
        reader.read(far, 22.0, None)
    told, outside = reader.read(far, 22.0, None, extrapolate=True)
    assert outside
    assert told.value == pytest.approx(sensor.valid_to + 20.0, abs=3.0)
    with pytest.raises(InputError, match="outside of the temperatures"):
        reader.read(213.0, 40.0, None)
    with pytest.raises(InputError, match="temperature was not measured"):
        reader.read(213.0, None, None)


def test_an_extrapolation_ends_where_the_inverse_becomes_ambiguous(sensor):
    """f = 213 + 2 z - z^2 turns at z = 1, half a width above the range: beyond, each f has two values."""
    of_z = {"centre": 0.0, "scale": 2.0, "valid_from": -1.0, "valid_to": 1.0, "temperature_c": None, "name": "x"}
    turned = sensor.model_copy(
        update={
            **of_z, "parameters": {"p0": 213.0, "p1": 2.0, "p2": -1.0}, "scatter_hz": 1e-3,
            "covariance": tuple(map(tuple, (1e-12 * np.eye(3)).tolist())), "reference": None,
        }
    )  # fmt: skip
    reader = Sensor.by(turned)

    def f_at(x):
        return 213.0 + 2.0 * (x / 2.0) - (x / 2.0) ** 2

    for x in (-6.5, -1.0, 0.3, 0.99, 1.8):
        told, outside = reader.read(f_at(x), None, None, extrapolate=True)
        assert (told.value, outside) == (pytest.approx(x, abs=1e-6), not -1.0 <= x <= 1.0)
        if not outside:
            assert reader.read(f_at(x), None, None)[0].value == told.value
    with pytest.raises(InputError, match=r"extrapolated to, -7 to 1\.9.* turns there.*ambiguous beyond"):
        reader.read(214.5, None, None, extrapolate=True)
    with pytest.raises(InputError, match=r"outside of the calibration, -1 to 1 mbar"):
        reader.read(214.5, None, None)


def test_a_dipole_is_read_up_to_where_the_magnets_would_touch(sensor):
    law = {"model": "dipole", "degree": 0, "parameters": {"a": 213.0 * 3.0**1.5, "x0": 1.0}}
    touching = sensor.model_copy(
        update={
            **law, "valid_from": 1.0, "valid_to": 3.0, "temperature_c": None, "reference": None, "unit": "mm",
            "covariance": ((1e-9, 0.0), (0.0, 1e-12)),
        }
    )  # fmt: skip
    reader = Sensor.by(touching)
    for x in (2.0, 0.0, -0.9, 8.0):
        told, _ = reader.read(213.0 * (3.0 / (x + 1.0)) ** 1.5, None, None, extrapolate=True)
        assert told.value == pytest.approx(x, abs=1e-6)


def test_a_temperature_beside_those_of_the_calibration_is_told(sensor):
    reader = Sensor.by(sensor)
    middle, wide = sensor.temperature_to_c, sensor.temperature_to_c - sensor.temperature_from_c
    f = PressureSensor(0).f_hz(1000.0, 22.0)
    assert not reader.read(f, middle, None)[1]
    assert reader.read(f, middle + 0.05 * wide, None)[1]


def test_why_there_is_no_mean(sensor):
    shots, _ = PressureSensor(3).shots(START_S, 2, 900.0)
    one = replace(shots, f_hz=np.array([shots.f_hz[0], 1.0]))
    report = report_of("two", one, sensor)
    assert (report.mean, len(report.shots)) == (None, 1)
    assert report.mean_reason == "1 of the shots have a reading, and a mean needs two"
    assert f"no mean: {report.mean_reason}" in readings_text(report)
    assert report_of("two", shots, sensor).mean_reason is None


def test_a_mean_is_not_drawn_into_the_range_of_the_calibration(sensor):
    """Three shots within it and one far above: the mean of the three would say that nothing was high."""
    shots, _ = PressureSensor(3).shots(START_S, 4, 900.0)
    high = replace(shots, f_hz=np.array([*shots.f_hz[:3], PressureSensor(0).f_hz(sensor.valid_to + 40.0, 22.0)]))
    report = report_of("four", high, sensor)
    assert (report.mean, len(report.shots), len(report.refused)) == (None, 3, 1)
    assert report.mean_reason.startswith("1 of the shots lie outside of the calibration, and the mean of the others")
    asked = report_of("four", high, sensor, extrapolate=True)
    assert (len(asked.mean.frames), asked.mean_reason) == (4, None)
    unfitted = replace(shots, refused=(UnreadShot(frame=9, reason="no signal"),))
    assert report_of("five", unfitted, sensor).mean is not None


def test_specimens_whose_names_differ_in_signs_have_keys_of_their_own(sensor, tmp_path):
    kept = Measurands(tmp_path / "measurands")
    names = ("rotor 1/a", "rotor 1-a", "rotor 1/a")
    labels = [kept.add(sensor.model_copy(update={"specimen": n, "key": key_of(n)})).label for n in names]
    assert labels == ["rotor-1-a@1", "rotor-1-a-2@1", "rotor-1-a@2"]
    assert kept.of_specimen("rotor 1-a").label == "rotor-1-a-2@1"
    assert kept.get("rotor-1-a").specimen == "rotor 1/a"


def test_a_calibration_that_turns_is_refused_with_the_place():
    sensor = PressureSensor(4)
    shots, mbar = sensor.shots(START_S, 100, 900.0)
    turned = Shots(
        frames=shots.frames, times_s=shots.times_s, f_hz=213.0 + 1e-3 * (mbar - 1000.0) ** 2, std_hz=shots.std_hz,
        celsius=shots.celsius, refused=(),
    )  # fmt: skip
    with pytest.raises(InputError, match=r"inverse is ambiguous.*f turns at 1000|f turns at 99"):
        calibrated("sensor", PRESSURE, turned, sensor.reference(START_S, START_S + 90e3), 1)


def test_too_few_pairs_and_none_at_all():
    sensor = PressureSensor(5)
    shots, _ = sensor.shots(START_S, 5, 900.0)
    with pytest.raises(InputError, match="5 pairs for 4 parameters"):
        calibrated("sensor", PRESSURE, shots, sensor.reference(START_S, START_S + 9e3), 1)
    with pytest.raises(InputError, match=r"no shot has a reading.*check zone"):
        calibrated("sensor", PRESSURE, shots, sensor.reference(START_S + 5 * DAY_S, START_S + 6 * DAY_S), 1)


def test_a_certificate_of_the_reference_that_had_expired():
    sensor = PressureSensor(7)
    shots, _ = sensor.shots(START_S, 20, 900.0)
    paper = {"number": "B1", "date": date(2020, 1, 1), "valid_until": date(2021, 1, 1)}
    declared = PRESSURE.model_copy(update={"reference": Influence(u=0.05, certificate=Certificate(**paper))})
    with pytest.raises(InputError, match=r"reference: certificate B1: expired on 2021-01-01.*valid then"):
        calibrated("sensor", declared, shots, sensor.reference(START_S, START_S + 20e3), 1)


LINE = "2026-03-01T00:0{}:00+00:00,{},{}"
GOOD = [LINE.format(k, 1000 + k, 0.1) for k in range(4)]


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        (["time,pressure [hPa],u [hPa]", *GOOD], r"the reference is in hPa, the measurand in mbar.*convert"),
        (["time,pressure,u", *GOOD], "names no unit"),
        (["time,force [mbar],u [mbar]", *GOOD], "the column is called 'force'"),
        (["time,pressure [mbar],u [mbar]", "2026-03-01T00:00:00,1000,0.1", *GOOD[1:]], r"line 2: .*no zone"),
        (["time,pressure [mbar],u [mbar]", GOOD[1], GOOD[0]], "not after the one before"),
        (["time,pressure [mbar],u [mbar]", GOOD[0], LINE.format(1, 1000, 0)], "standard uncertainty is 0"),
        (["time,pressure [mbar],u [mbar]", GOOD[0], LINE.format(1, "nan", 1)], "not finite"),
        (["time,pressure [mbar],u [mbar]", GOOD[0], "yesterday,1000,0.1"], "not a time and numbers"),
        (["time,pressure [mbar],u [mbar]"], "fewer than two readings"),
        (["time,pressure [mbar],u [mbar]", GOOD[0], "", ""], "fewer than two readings"),
        (["time;pressure [mbar];u [mbar]", *GOOD], "it has semicolons: columns are separated by commas"),
        (["time\tpressure [mbar]", *GOOD], "it has tabs: columns are separated by commas"),
        (["time,pressure [mbar],u [mbar]", "2026-03-01T00:00:00Z,1000,2,0,1", *GOOD[1:]], "5 cells.*with a point"),
        (["time,pressure [mbar],u [mbar]", '2026-03-01T00:00:00Z,"1000,2",0.1', *GOOD[1:]], "float: '1000,2'"),
        (["time,pressure [mbar],u [mbar]", "01.03.2026 00:00:00,1000,0.1", *GOOD[1:]], "line 2: .*ISO 8601"),
        (["time,pressure [mbar],u [mbar]", GOOD[0], LINE.format(1, 1000, "0_1")], "line 3: .*float: '0_1'"),
        (["time,pressure [mbar],u [mbar]", GOOD[0], LINE.format(1, 1000, -0.1)], "standard uncertainty is -0.1"),
        (["time,pressure [mbar],u [mbar]", GOOD[0], LINE.format(1, 1000, "inf")], "not finite"),
        (["time,pressure [mbar],u [mbar]", GOOD[0], GOOD[0]], "line 3: the time is not after the one before"),
        (["time,pressure [mbar],u [Pa]", *GOOD], "the reference is in Pa, the measurand in mbar"),
    ],
)  # fmt: skip
def test_reference_files_that_are_refused(lines, said, tmp_path):
    path = tmp_path / "reference.csv"
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match=said):
        read_reference(path, PRESSURE)


def test_a_byte_order_mark_and_degrees_as_a_sign_are_read():
    lines = ["\ufefftime,temperature [ °C ],u [degC]", *GOOD]
    assert len(reference_from("\r\n".join(lines), "it", Measurand(name="temperature", unit="degC")).values) == 4


def test_a_model_that_does_not_hold_for_other_readings_is_told():
    """A parabola, read from one end to the other: a straight line is wrong where it has not been."""
    times, d = START_S + 60.0 * np.arange(40), np.linspace(-50.0, 50.0, 40)
    f = 213.0 - 0.06 * d + 3e-4 * d**2 + 1e-3 * np.random.default_rng(1).standard_normal(40)
    nothing = np.full(40, np.nan)
    shots = Shots(
        frames=tuple(range(40)), times_s=times, f_hz=f, std_hz=np.full(40, 1e-4), celsius=nothing, refused=()
    )  # fmt: skip
    reference = Reference(times, 1000.0 + d, np.full(40, 1e-3))

    def told(degree):
        declared = PRESSURE.model_copy(update={"degree": degree, "corrected_for": None})
        made = calibrated("sensor", declared, shots, reference, 1)
        return [note for note in made.notes if "should cover 95 %: record more" in note]

    assert told(2) == []
    assert len(told(1)) == 1


def test_shots_without_a_temperature_outside_of_the_readings_do_no_harm():
    sensor = PressureSensor(9)
    shots, _ = sensor.shots(START_S, 200, 900.0)
    shots.celsius[150:] = np.nan
    made = calibrated("sensor", PRESSURE, shots, sensor.reference(START_S, START_S + 149 * 900.0 - 1200.0), 1)
    assert 100 < made.pairs < 150


def test_what_is_declared_of_the_reference_is_in_each_reading(sensor):
    shots, _ = PressureSensor(3).shots(START_S, 200, 900.0)
    known = Influence(half_width=3.0, distribution="rectangular", dof=3.0, kind="A", source="bridge")
    declared = PRESSURE.model_copy(update={"reference": known})
    reference = PressureSensor(3).reference(START_S, START_S + 180e3)
    told, _ = Sensor.by(calibrated("sensor", declared, shots, reference, 1)).read(213.0, 22.0, None)
    (line,) = [each.input for each in told.contributions if each.input.name == "reference"]
    assert (line.u, line.dof, line.kind) == (pytest.approx(3.0 / 3.0**0.5), 3.0, "A")
    assert (line.distribution, line.source) == ("rectangular", "bridge")
    assert told.k > 2.5  # of Student's t with three to four degrees of freedom: that line dominates


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"parameters": {"p0": 213.0}}, "its model has 4 parameters, and the file 1"),
        ({"covariance": ((1e-6,),)}, "the covariance is not 4 by 4"),
        (
            {"covariance": tuple(map(tuple, np.diag([1.0, -1.0, 1.0, 1.0]).tolist()))},
            "the covariance of its parameters",
        ),
        ({"covariance": tuple(map(tuple, (np.eye(4) + np.eye(4, k=1)).tolist()))}, "the covariance of its parameters"),
        ({"scale": 0.0}, "scale, range"),
        ({"valid_to": -1.0}, "scale, range"),
        ({"scatter_hz": float("nan")}, "a number is not finite"),
    ],
)
def test_a_calibration_that_somebody_has_changed(sensor, tmp_path, values, said):
    kept = Measurands(tmp_path)
    kept.add(sensor)
    (tmp_path / "sensor@1.json").write_text(json.dumps({**sensor.model_dump(), **values}))
    with pytest.raises(InputError, match=rf"sensor@1.json: is no calibration of a measurand\. {said}.*restore"):
        kept.get("sensor")
    assert (kept.all()[0], len(kept.all()[1])) == ([], 1)


def test_a_model_that_is_not_installed(sensor):
    with pytest.raises(InputError, match=r"\[measurand\] model: no model .*'cubic'.*there are polynomial and dipole"):
        Sensor.by(sensor.model_copy(update={"model": "cubic"}))


def test_a_reference_that_is_less_certain_than_it_changes():
    sensor = PressureSensor(8)
    shots, _ = sensor.shots(START_S, 50, 900.0)
    reference = sensor.reference(START_S, START_S + 50 * 900.0)
    vague = Reference(reference.times_s, reference.values, np.full(len(reference.values), 100.0))
    with pytest.raises(InputError, match=r"changes by \d\d\.\d mbar, and its readings have u = 100"):
        calibrated("sensor", PRESSURE, shots, vague, 1)


@pytest.mark.parametrize(("offset_k", "slope"), [(0.0, 1.0), (40.0, 1.0), (9.0, 1.8)])
def test_a_warm_chamber_is_no_other_unit(offset_k, slope):
    celsius = np.linspace(20.0, 24.0, 20)
    refuse_other_unit(Measurand(name="temperature", unit="degC"), offset_k + slope * celsius, celsius, "sensor")


@pytest.mark.parametrize("hours", [1, -2, 12])
def test_a_reference_of_another_zone_is_told(hours):
    sensor = PressureSensor(9)
    shots, _ = sensor.shots(START_S, 200, 900.0)
    right = sensor.reference(START_S - DAY_S, START_S + 3.0 * DAY_S)
    wrong = Reference(right.times_s + 3600.0 * hours, right.values, right.u)
    said = rf"times of the reference are wrong.*shifted by {re.escape(f'{-hours:+d}')} h they leave.*zone"
    with pytest.raises(InputError, match=said):
        calibrated("sensor", PRESSURE, shots, wrong, 1)


def _specimen_file(folder):
    _, text = load_specimen("thread")
    path = folder / "sensor.toml"
    path.write_text(text + '\n[measurand]\nname = "pressure"\nunit = "mbar"\nlongest_lag_s = 0.0\n')
    return path


@pytest.mark.long
def test_commands_in_the_simulated_world(tmp_path):
    """A membrane moves the stator of a simulated resonator; the reference is what the world says, with noise."""
    specimen, file, folder = _specimen_file(tmp_path), tmp_path / "cal.h5", tmp_path / "measurands"
    housing = {"swing_mbar": 50.0, "period_s": 600.0, "f_nat_hz_per_mbar": -0.06}
    sets = [x for key, value in housing.items() for x in ("--set", f"backends.simulated.housing.{key}={value}")]
    sets += ["--set", "backends.simulated.effects.temperature.sd_k=0.02"]
    done = here(
        "measure", "--resonator", specimen, "--shots", 12, "--rx-s", "0.4", "--pause-s", 45, *sets, "--out", file
    )
    assert done.returncode == 0, done.stderr
    reference, truth = tmp_path / "reference.csv", pressures(file)
    reference.write_text(barometer(file, housing["period_s"]))
    where = ("--measurands", folder)
    done = here("measurand", "calibrate", specimen, file, "--reference", reference, *where)
    assert done.returncode == 0, done.stderr
    assert "pressure of" in done.stdout
    assert "not declared" in done.stdout
    told = tmp_path / "told.json"
    done = here("measurand", "read", file, *where, "--json", told, "--csv", tmp_path / "told.csv")
    assert done.returncode == 0, done.stderr
    report = json.loads(told.read_text())
    assert report["calibration"].endswith("@1")
    found = np.array([shot["value"] for shot in report["shots"]])
    expected = truth[[shot["frames"][0] for shot in report["shots"]]]
    assert len(found) >= 10
    # All shots share the errors of one calibration, so that they are outside of U together or not at all.
    assert (np.abs(found - expected) <= 2.0 * np.array([shot["U"] for shot in report["shots"]])).all()
    assert "@1" in here("measurand", "list", *where).stdout
    again = here("measurand", "calibrate", specimen, file, "--reference", reference, *where)
    assert "@2" in again.stdout
    assert_one_line_error(here("measurand", "read", file, *where, "--calibration", "nothing"), 2, "no calibration")
    assert_one_line_error(
        here("measurand", "calibrate", "jewel", file, "--reference", reference, *where), 2, "declared as no sensor"
    )


def test_a_temperature_that_is_not_corrected_for_is_told():
    sensor = PressureSensor(6)
    shots, _ = sensor.shots(START_S, 200, 900.0)
    blind_to_it = PRESSURE.model_copy(update={"corrected_for": None})
    made = calibrated("sensor", blind_to_it, shots, sensor.reference(START_S, START_S + 180e3), 1)
    assert made.by_temperature_hz_per_k.significant
    assert made.by_temperature_hz_per_k.value == pytest.approx(-0.23, rel=0.1)
    assert any("corrected_for" in note for note in made.notes)
    assert made.resolution > 2.0 * SCATTER_HZ / 0.06  # what it does is in the scatter, so that U holds nevertheless
