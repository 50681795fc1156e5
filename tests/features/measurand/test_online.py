"""Readings while shots are made: events, the alarm at a limit, numbers for Prometheus; and of a fit of the library."""

import shutil
from contextlib import closing
from types import SimpleNamespace

import numpy as np
import pytest
from pydantic import ValidationError

import platform_daemon as pd_
from drivers.specimen import Measurand
from platform_daemon.core.hardware.catalogue import open_catalogue
from platform_daemon.core.recordings.indexed import IndexedPoint, IndexedRecording, IndexedSpecimen
from platform_daemon.core.recordings.recording_index import open_index
from platform_daemon.core.schemas.acquisitions import ShotPage, ShotReport
from platform_daemon.core.schemas.events import FitEvent
from platform_daemon.core.schemas.fits import ParameterEstimate, unfitted
from platform_daemon.core.settings import load_specimen
from platform_daemon.core.web.metrics import Metrics
from platform_daemon.features.alarms.board import AlarmBoard
from platform_daemon.features.alarms.rules import Rules
from platform_daemon.features.measurand.library import Measurands
from platform_daemon.features.measurand.online import NewestCalibrations, OnlineReadings, with_readings
from platform_daemon.features.measurand.work import calibrated
from platform_daemon.features.schedules.readings import with_readings as ledger_with_readings
from platform_daemon.features.schedules.schema import LedgerPage, LedgerRow
from platform_daemon.features.trends import readings as readings_of_trends
from platform_daemon.features.trends.figure import draw_trend
from platform_daemon.features.trends.indexed import update_index
from platform_daemon.features.trends.report import trend_csv, trend_text
from platform_daemon.features.trends.trend import specimen_trend
from tests.kit.pressure_sensor import PRESSURE, START_S, PressureSensor

LIMITS = """
[measurand]
name = "pressure"
unit = "mbar"
lowest = 980.0
highest = 1020.0
"""


@pytest.fixture(scope="module")
def calibration():
    shots, _ = PressureSensor(3).shots(START_S, 200, 900.0)
    name = load_specimen("thread")[0].name
    return calibrated(name, PRESSURE, shots, PressureSensor(3).reference(START_S, START_S + 180e3), 1)


@pytest.fixture
def told():
    return []


@pytest.fixture
def readings(calibration, told, tmp_path):
    Measurands(tmp_path / "measurands").add(calibration)
    (tmp_path / "resonators").mkdir()
    (tmp_path / "resonators" / "sensor.toml").write_text(load_specimen("thread")[1] + LIMITS)
    catalogue = open_catalogue(tmp_path / "added", tmp_path / "sequences", tmp_path / "resonators")
    return OnlineReadings(tmp_path / "measurands", catalogue, told.append, lambda: START_S + 3e5)


def fitted(calibration, mbar, celsius=22.0, **more):
    f = None if mbar is None else PressureSensor(0).f_hz(mbar, celsius)
    values = {"specimen": calibration.specimen, "temperature_c": celsius, "f_nat_hz": f, **more}
    return FitEvent(
        job="a", shot=1, verdict="good", reason=None, f_nat_std_hz=1e-4, phi_max_rad=0.9, nrmse=0.01, chi2_per_dof=1.0,
        whiteness=1.0, warnings=(), seconds=0.01, **values,
    )  # fmt: skip


def test_a_limit_raises_an_alarm_once_the_reading_is_beyond_it_by_more_than_u(readings, told, calibration, tmp_path):
    board = AlarmBoard(tmp_path / "state.sqlite", lambda event: None)
    rules, name = Rules(board), f"measurand:{calibration.specimen}"

    def after(mbar, **more):
        readings.see(fitted(calibration, mbar, **more))
        rules.see(told[-1])
        return name in board.standing()

    assert not after(1000.0)
    assert told[-1].value == pytest.approx(1000.0, abs=told[-1].U)
    assert (told[-1].within, told[-1].calibration) == (True, calibration.label)
    assert not after(1020.2)  # beyond it by less than U
    assert told[-1].within is None
    assert after(1025.0)
    assert "beyond its limit" in board.all()[0].what
    assert after(1019.8)  # ends only where it surely is within
    assert not after(1010.0)
    assert after(1000.0, celsius=60.0)
    assert "cannot be read" in board.all()[0].what
    assert "outside of the temperatures" in told[-1].reason


def test_prometheus_has_the_newest_reading(readings, told, calibration, tmp_path):
    metrics = Metrics(SimpleNamespace(status=_raise), lambda: 0, tmp_path)
    readings.see(fitted(calibration, 1000.0))
    metrics.see(told[-1])
    text = metrics.text().decode()
    lines = [line for line in text.splitlines() if line.startswith("mmr_measurand{")]
    assert len(lines) == 1
    assert 'unit="mbar"' in lines[0]
    assert float(lines[0].split()[-1]) == told[-1].value
    assert f"{told[-1].U}" in next(li for li in text.splitlines() if li.startswith("mmr_measurand_expanded"))


def _raise():
    raise pd_.InputError("nobody answers")


def test_what_is_no_sensor_makes_no_event(readings, told, calibration):
    readings.see(fitted(calibration, 1000.0, specimen="another"))
    readings.see(fitted(calibration, None))
    readings.see(fitted(calibration, 1000.0, specimen=None))
    assert not told


def test_a_new_calibration_is_used_at_once(readings, told, calibration, tmp_path):
    readings.see(fitted(calibration, 1000.0))
    Measurands(tmp_path / "measurands").add(calibration)
    readings.see(fitted(calibration, 1000.0))
    assert [each.calibration for each in told] == [f"{calibration.key}@1", f"{calibration.key}@2"]


def test_each_good_shot_of_a_sensor_has_what_it_reads(calibration, tmp_path):
    folder = tmp_path / "measurands"
    Measurands(folder).add(calibration)

    def shot(number, mbar, celsius=22.0):
        f = ParameterEstimate(value=PressureSensor(0).f_hz(mbar, celsius), std=1e-4)
        fit = unfitted(number - 1, "").model_copy(update={"verdict": "good", "parameters": {"f_nat_hz": f}})
        return ShotReport(
            shot=number, frame=number - 1, time_stamp="2026-06-01T00:00:00+00:00", blank=False, verdict="good",
            reason=None, temperature_c=celsius, fit=fit,
        )  # fmt: skip

    blank = shot(3, 1000.0).model_copy(update={"fit": None})
    page = ShotPage(items=(shot(1, 990.0), shot(2, 1000.0, 60.0), blank), next=None)
    read, hot, nothing = with_readings(page, calibration.specimen, NewestCalibrations(folder)).items
    assert read.measurand.value == pytest.approx(990.0, abs=read.measurand.U)
    assert (read.measurand.unit, read.measurand.calibration) == ("mbar", calibration.label)
    assert hot.measurand.value is None
    assert "outside of the temperatures" in hot.measurand.reason
    assert nothing.measurand is None
    assert with_readings(page, "another", NewestCalibrations(folder)) is page


def test_a_trend_of_a_sensor_has_value_and_u_of_every_point(calibration, tmp_path, monkeypatch):
    pressures = [985.0, 995.0, 1005.0]
    report = _trend_of(pressures, calibration, tmp_path, monkeypatch)
    told = report.measurand
    for value, u, mbar in zip(told.value, told.U, pressures, strict=True):
        assert value == pytest.approx(mbar, abs=u)
    assert told.U[2] < 0.7 * told.U[0]  # a mean of nineteen shots scatters less than one
    assert told.low == told.smoothed == told.high == (None, None, None)  # the chart learns
    assert "pressure: 100" in trend_text(report)
    assert "pressure [mbar],U of pressure [mbar]" in trend_csv(report)


def test_the_control_chart_of_a_sensor_is_told_in_its_unit(calibration, tmp_path, monkeypatch):
    """A standard deviation of the chart is that of the pressure here, because every frequency is that of a pressure."""
    pressures = np.random.default_rng(3).normal(1000.0, 2.0, 40)
    report = _trend_of(pressures.tolist(), calibration, tmp_path, monkeypatch)
    told = report.measurand
    (chart,) = [each for each in report.charts if each.quantity == "f_nat_hz"]
    assert PressureSensor(0).f_hz(told.smoothed[-1], 22.0) == pytest.approx(chart.smoothed[-1], abs=0.02)
    middle = 0.5 * (told.low[-1] + told.high[-1])
    assert middle == pytest.approx(pressures.mean(), abs=1.0)
    half = 0.5 * (told.high[-1] - told.low[-1])
    assert half / chart.limit[-1] == pytest.approx(pressures.std(), rel=0.2)
    assert (told.smoothed[-1] - middle) / half == pytest.approx(-chart.ewma[-1] / chart.limit[-1], abs=0.05)  # f falls
    assert f"limits {told.low[-1]:.6g} to {told.high[-1]:.6g} mbar" in trend_text(report)


def test_the_picture_of_a_trend_of_a_sensor_is_in_its_unit(calibration, tmp_path, monkeypatch):
    pressures = np.random.default_rng(3).normal(1000.0, 2.0, 40)
    report = _trend_of(pressures.tolist(), calibration, tmp_path, monkeypatch)
    read, mean, f_nat, _ = draw_trend(report).axes
    assert (read.get_ylabel(), mean.get_title()) == ("pressure / mbar", "weighted mean and limits / mbar")
    assert "Hz" in f_nat.get_ylabel()
    (bars,) = read.containers
    assert bars.lines[0].get_ydata() == pytest.approx(pressures, abs=0.5)
    ends = np.array([bar.get_segments() for bar in bars.lines[2]])[0, :, :, 1]
    assert 0.5 * np.diff(ends)[:, 0] == pytest.approx(report.measurand.U)
    assert mean.lines[0].get_ydata()[-1] == pytest.approx(report.measurand.smoothed[-1])
    assert mean.get_ylim()[0] < report.measurand.low[-1] < report.measurand.high[-1] < mean.get_ylim()[1]
    plain = draw_trend(report.model_copy(update={"measurand": None}))
    assert [axes.get_ylabel() for axes in plain.axes] == [f_nat.get_ylabel(), ""]


def test_a_point_is_read_once_and_anew_by_a_new_calibration(calibration, tmp_path, monkeypatch):
    made = []
    reading_of = readings_of_trends.reading_of
    monkeypatch.setattr(readings_of_trends, "reading_of", lambda *a, **k: made.append(a) or reading_of(*a, **k))
    pressures = [985.5, 995.5, 1005.5]
    first = _trend_of(pressures, calibration, tmp_path / "a", monkeypatch).measurand
    assert len(made) == 3
    assert _trend_of(pressures, calibration, tmp_path / "b", monkeypatch).measurand == first
    assert len(made) == 3
    offset = {**calibration.parameters, "p0": calibration.parameters["p0"] + 0.06}
    other = calibration.model_copy(update={"parameters": offset})
    changed = _trend_of(pressures, other, tmp_path / "c", monkeypatch).measurand
    assert len(made) == 6
    assert np.subtract(changed.value, first.value) == pytest.approx([1.0] * 3, abs=0.2)


def _trend_of(pressures, calibration, folder, monkeypatch):
    """Recordings of a day each; of the first points one shot, of later ones more."""
    Measurands(folder).add(calibration)
    points = []
    for k, mbar in enumerate(pressures):
        at = f"2026-{6 + k // 30:02}-{1 + k % 30:02}T00:00:00+00:00"
        values = {"f_nat_hz": PressureSensor(0).f_hz(mbar, 22.0)}
        points.append(IndexedPoint(at=at, shots=1 + 9 * min(k, 2), temperature_c=22.0, field_t=None, values=values))
    recording = IndexedRecording(
        identifier="a", begun=points[0].at, specimen="S", operator="", frames=30, good=30, calibration=None,
        fit="d30", resonator=calibration.specimen, points=points,
    )  # fmt: skip
    specimen = IndexedSpecimen(("a",), points[0].at, points[-1].at, 30, {calibration.specimen: 1}, {}, ())
    monkeypatch.setattr(readings_of_trends, "indexed_specimen", lambda folder, name: specimen)
    return readings_of_trends.with_measurand(specimen_trend("S", [recording]), folder / "recordings", folder)


def test_a_row_of_the_ledger_has_what_its_recording_reads(calibration, measured, tmp_path):
    """The recording is of the platform; what it is read by is a curve for its own frequency."""
    recordings, measurands = tmp_path / "recordings", tmp_path / "measurands"
    recordings.mkdir()
    shutil.copy(measured / "j.h5", recordings / "night.h5")
    update_index(recordings)
    row = LedgerRow.model_validate(
        dict.fromkeys(LedgerRow.model_fields, None) | {"number": 1, "due": "", "deadline": "", "state": "run"}
    )
    page = LedgerPage(items=(row.model_copy(update={"recording": "night"}), row), next=None)
    assert ledger_with_readings(page, recordings, measurands) is page  # nothing is calibrated yet
    with closing(open_index(recordings)) as index:
        resonator = index.summaries(["night"])["night"].resonator
        f = np.mean([shot.values["f_nat_hz"] for shot in index.shots("night")])
    shift = f - PressureSensor(0).f_hz(1000.0, 22.0)
    moved = {**calibration.parameters, "p0": calibration.parameters["p0"] + shift}
    Measurands(measurands).add(
        calibration.model_copy(update={"specimen": resonator, "parameters": moved, "temperature_to_c": 40.0})
    )
    with_it, without = ledger_with_readings(page, recordings, measurands).items
    assert with_it.measurand.value == pytest.approx(1000.0, abs=5.0)  # the shots are not all at 22 degrees
    assert 0.0 < with_it.measurand.U < 1.0
    assert without.measurand is None
    assert "measurand" not in without.model_dump()


def test_limits_in_the_wrong_order_are_refused():
    with pytest.raises(ValidationError, match="highest is not above lowest"):
        Measurand(name="pressure", unit="mbar", lowest=2.0, highest=1.0)


def test_a_fit_of_the_library_is_a_reading(calibration, measured, tmp_path):
    Measurands(tmp_path).add(calibration)
    fit = pd_.fit(pd_.open(measured / "j.h5"), window="n50")
    found = fit.measurand(calibration.key, folder=tmp_path, extrapolate=True)
    f = fit["f_nat_hz"].value
    expected = next(x for x in (900 + k * 0.05 for k in range(4000)) if PressureSensor(0).f_hz(x, 22.0) <= f)
    assert found.value == pytest.approx(expected, abs=30.0)
    assert {line.input.name for line in found.contributions} >= {"scatter", "calibration"}
    with pytest.raises(pd_.InputError, match="no calibration 'nothing'"):
        fit.measurand("nothing", folder=tmp_path)
