"""Angle files: their layout, and clocks that are not even."""

import numpy as np
import pytest

from drivers.errors import RecordingError
from platform_daemon.core.recordings.angle_series import is_time_series, read_angles
from platform_daemon.diagnosis.report import diagnosis_report
from platform_daemon.features.diagnose.load_shots import diagnose_input, load_diagnosis_input
from tests.kit.specimen_files import PENDULUM, THREAD, copied, pendulum, swing


def test_a_measured_pendulum_is_read_whole():
    found = read_angles(PENDULUM)
    assert found.angle_rad.shape == (1, 55001)
    assert found.sampling_rate_hz == pytest.approx(1000.0, rel=1e-9)
    assert found.clock == ()


def test_recordings_and_angle_series_are_told_apart():
    assert is_time_series(PENDULUM)
    assert not is_time_series(THREAD)


def test_degrees_become_radians(tmp_path):
    t, angle = swing()
    path = pendulum(tmp_path, t, np.degrees(angle), units="deg")
    assert read_angles(path).angle_rad[0] == pytest.approx(angle)


def test_a_gap_in_the_time_column_is_reported_and_never_bridged(tmp_path):
    t, angle = swing()
    keep = np.ones(t.size, dtype=bool)
    keep[1500:1507] = False
    found = read_angles(pendulum(tmp_path, t[keep], angle[keep]))
    assert "8 steps before sample 1500" in found.clock[0]
    # The longer side of the gap, sample by sample.
    assert np.array_equal(found.angle_rad[0], angle[1507:])
    assert found.sampling_rate_hz == pytest.approx(400.0, rel=1e-9)


def test_a_clock_that_is_never_even_is_refused(tmp_path):
    t, angle = swing()
    t = t + np.random.default_rng(0).uniform(0.0, 0.9 / 400.0, t.size)
    with pytest.raises(RecordingError, match="uneven"):
        read_angles(pendulum(tmp_path, t, angle))


def _back(t):
    t[3000:] -= 2.0


def _still(t):
    t[3000:3010] = t[2999]


def _slower(t):
    t[3000:] += 3.0 * np.arange(t.size - 3000) / 400.0


def _faster_for_a_while(t):
    t[3020:] -= 20 * 0.5 / 400.0
    t[3000:3020] = t[3000] + 0.5 * np.arange(20) / 400.0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (_back, r"/time: runs back from 7\.4975 s to 5\.5 s at sample 3000\."),
        (_still, r"/time: repeats: sample 3000 .* 7\.4975 s, and 9 more times"),
        (_slower, r"/time: mixes sampling rates: 400 Hz, but 100 Hz from sample 3000 at 7\.5 s to sample 4799"),
        (_faster_for_a_while, "/time: mixes sampling rates: 400 Hz, but 800 Hz from sample 3000"),
    ],
)
def test_what_is_no_time_column_is_refused_with_the_place(tmp_path, change, words):
    t, angle = swing()
    change(t)
    with pytest.raises(RecordingError, match=words):
        read_angles(pendulum(tmp_path, t, angle))


def test_many_holes_are_no_other_rate(tmp_path):
    t, angle = swing()
    keep = np.ones(t.size, dtype=bool)
    keep[np.random.default_rng(1).integers(1100, t.size, 60)] = False
    keep[700:900] = False
    found = read_angles(pendulum(tmp_path, t[keep], angle[keep]))
    assert found.clock


@pytest.mark.parametrize(
    ("time_s", "angle", "units", "words"),
    [
        (np.arange(200.0), np.zeros(199), "rad", "199 samples"),
        (np.arange(200.0), np.zeros((2, 200)), "rad", r"\(2, 200\): 2 channels.*a file of its own"),
        (np.arange(200.0), np.zeros((200, 1)), "rad", "transpose"),
        (np.arange(200.0), np.zeros(200, complex), "rad", "complex"),
        (np.arange(200.0), np.zeros(200), "V", "units"),
        (np.arange(200.0), np.zeros(200), "%", "is in '%'.*an angle in rad or deg"),
        (np.arange(200.0), np.zeros(200), "counts", "is in 'counts'.*an angle in rad or deg"),
        (np.full(200, np.nan), np.zeros(200), "rad", "200 values that are not finite, the first at sample 0"),
        (np.zeros(200), np.zeros(200), "rad", "repeats: sample 1 .* 198 more"),
    ],
)
def test_what_is_no_angle_series_is_refused_by_name(tmp_path, time_s, angle, units, words):
    with pytest.raises(RecordingError, match=words) as caught:
        read_angles(pendulum(tmp_path, time_s, angle, units=units))
    assert "angle.h5" in str(caught.value)
    assert "Remedy" in str(caught.value)


def test_values_that_are_not_finite_are_said_to_be_so(tmp_path):
    t, angle = swing()
    angle[100] = np.nan
    assert not read_angles(pendulum(tmp_path, t, angle)).finite
    assert read_angles(copied(tmp_path, PENDULUM)).finite


@pytest.mark.long
def test_friction_that_falls_with_the_speed_is_what_a_measured_pendulum_asks_for():
    found = diagnose_input(load_diagnosis_input([PENDULUM], "thread", "angle"), lambda *_: None)
    report = diagnosis_report(found).model_dump(mode="json")
    assert "stribeck_friction" in [effect["id"] for effect in report["effects"]]
    assert all(effect["strength"]["value"] > 0.0 for effect in report["effects"])
    assert report["parameters_after"]["lambda_per_s"]["value"] > 0.0
    assert report["held_out"]["nrmse_after"] < 0.025 < 0.2 < report["held_out"]["nrmse_before"]
    assert report["verdict"] == "partly_explained"
    assert not report["integrity"]
