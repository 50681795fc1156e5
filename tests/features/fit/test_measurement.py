"""Recordings and angles look the same to whoever analyses them."""

import numpy as np
import pytest

from drivers.errors import InputError, RecordingError
from platform_daemon.core.recordings.reader import read_calibration
from platform_daemon.core.recordings.series_writer import SeriesWriter
from platform_daemon.features.fit.fit import fit_measurement, fit_stored_frame
from platform_daemon.features.fit.fit_request import FitRequest, FitSettings
from platform_daemon.features.fit.harmonics import frame_harmonics
from platform_daemon.features.fit.measurement import (
    AngleMeasurement,
    VoltageMeasurement,
    open_for_fit,
    open_measurement,
    open_voltages,
)
from tests.kit.recording_files import header, shot
from tests.kit.specimen_files import JEWEL, THREAD, pendulum, swing, without


def test_a_recording_is_calibrated_and_says_what_it_holds():
    found = open_measurement(JEWEL)
    assert isinstance(found, VoltageMeasurement)
    assert (found.frames, found.variant, found.notes) == (2, "jewel", ())
    signal = found.signal(1)
    assert signal.record.quantity == "dmdt"
    assert np.array_equal(signal.raw, found.recording.rx_volts(1))


def test_without_a_calibration_there_are_volts_and_a_note(tmp_path):
    found = open_measurement(without(tmp_path, "calibration"))
    assert found.signal(0).record.quantity == "voltage"
    assert found.notes[0].startswith("no calibration")
    again = open_measurement(found.path, (read_calibration(THREAD), "another"))
    assert (again.signal(0).record.quantity, again.notes) == ("dmdt", ())


def test_an_angle_is_one_frame_of_a_pendulum(tmp_path):
    found = open_measurement(pendulum(tmp_path, *swing()))
    assert isinstance(found, AngleMeasurement)
    assert (found.frames, found.variant, found.calibration, found.times_s()) == (1, "thread", None, [0.0])
    assert found.signal(0).record.quantity == "angle"
    assert found.signal(0).clipping() is None
    with pytest.raises(InputError, match="frame 1 does not exist"):
        found.signal(1)
    with pytest.raises(RecordingError, match="no calibration applies"):
        open_measurement(found.path, (read_calibration(THREAD), "another"))
    with pytest.raises(RecordingError):
        open_voltages(found.path)


def test_the_model_is_the_callers_else_the_files(tmp_path):
    assert open_measurement(JEWEL).under(None)[1] == "jewel"
    assert open_measurement(JEWEL).under("thread", ["quadratic_drag"])[1] == "thread+quadratic_drag"
    silent = open_measurement(without(tmp_path, "resonator"))
    with pytest.raises(RecordingError, match="--variant"):
        silent.under(None)
    assert silent.under("thread")[1] == "thread"


def test_frames_that_were_not_excited_or_that_the_daemon_refused_are_excused(tmp_path):
    with SeriesWriter.create(tmp_path / "a.h5", header()) as writer:
        for taken in (shot(1, blank=True), shot(2, verdict="refused", reason="x"), shot(3)):
            writer.add_shot(taken)
        writer.finish(())
    found = open_measurement(tmp_path / "a.h5")
    assert [found.excuse(k) for k in range(3)] == ["a blank shot, without excitation", "x", None]
    assert fit_stored_frame(found, 1, FitRequest("thread"))[0].reason == "x"
    assert [fit_stored_frame(found, k, FitRequest("thread"))[0].verdict for k in range(2)] == ["blank", "refused"]
    assert isinstance(found, VoltageMeasurement)
    assert [frame_harmonics(found, k).verdict for k in range(2)] == ["blank", "refused"]
    assert found.times_s() == [1001.0, 1002.0, 1003.0]
    assert found.conditions(2).temperature_c == 21.5


def test_what_cannot_be_held_is_refused_before_any_fit(tmp_path):
    with pytest.raises(InputError, match="cannot be held fixed"):
        open_for_fit(pendulum(tmp_path, *swing()), FitSettings(fixed={"m_r_am2": 0.01}))


def test_a_file_is_fitted_whatever_it_holds(tmp_path):
    angle, ask = open_for_fit(pendulum(tmp_path, *swing()), FitSettings(window=10.0))
    report = fit_measurement(angle, ask)
    assert report.frames[0].values["f_nat_hz"] == pytest.approx(2.0, abs=0.05)
    assert (report.calibration, report.notes) == (None, ())


def test_a_few_degrees_that_are_said_to_be_radians_are_suspected(tmp_path):
    t, angle = swing(seconds=6.0, rate_hz=100.0, start_rad=0.05)
    wrong, right = (
        fit_stored_frame(open_measurement(pendulum(tmp_path, t, values, name)), 0, FitRequest("thread"))[0]
        for values, name in ((np.degrees(angle), "wrong.h5"), (angle, "right.h5"))
    )
    assert "beyond 90 deg: if these are degrees" in wrong.reason
    assert right.verdict == "good"
