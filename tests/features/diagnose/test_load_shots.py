"""From files to shots of one specimen."""

import re

import h5py
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from drivers.errors import InputError, RecordingError
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.features.diagnose.load_shots import NothingToDiagnoseError, diagnose_input, load_diagnosis_input
from platform_daemon.features.diagnose.shot_reading import ABSORBED
from tests.kit.specimen_files import JEWEL, PENDULUM, RUNS, THREAD, copied, pendulum, swing, without


def test_every_frame_of_every_file_becomes_a_shot_with_noise(tmp_path):
    found = load_diagnosis_input([THREAD, copied(tmp_path)])
    assert [s.group for s in found.shots] == [THREAD.name] * 2 + ["copy.h5"] * 2
    assert found.model.name == "thread"
    for shot in found.shots:
        assert shot.record.quantity == "dmdt"
        assert np.all(shot.noise.sd > 0.0)
        assert np.array_equal(shot.sensitivity, open_recording(THREAD).calibration.sensitivity)


def test_a_file_named_twice_counts_once():
    assert len(load_diagnosis_input([THREAD, THREAD]).shots) == 2


def test_angle_files_are_recognised_and_need_no_variant():
    found = load_diagnosis_input(RUNS)
    assert [s.record.quantity for s in found.shots] == ["angle"] * 3
    assert found.model.name == "thread"
    assert any("no variant was named" in n for n in found.notes)


@pytest.mark.parametrize(("law", "declared"), [(np.sin, "thread"), (lambda phi: phi, "thread_small_angle")])
def test_an_angle_that_nobody_named_is_that_of_a_pendulum_or_of_a_spring(tmp_path, law, declared):
    """By scipy: 1.2 Hz from 80 degrees, with dry friction that neither model has."""

    def motion(t, y):
        return y[1], -((2.0 * np.pi * 1.2) ** 2) * law(y[0]) - 0.02 * y[1] - 0.05 * np.tanh(y[1] / 1e-2)

    times = np.arange(0.0, 40.0, 0.01)
    angle = solve_ivp(motion, (0.0, 40.0), (1.4, 0.0), t_eval=times, rtol=1e-9, atol=1e-9).y[0]
    angle += np.random.default_rng(7).normal(0.0, 1e-3, times.size)
    path = tmp_path / "swing.csv"
    np.savetxt(path, np.column_stack([times, angle]), delimiter=",", header="time_s,phi_rad", comments="")
    found = load_diagnosis_input([path])
    assert found.model.name == declared
    assert any(f"the declared model is {declared}" in n for n in found.notes)
    assert load_diagnosis_input([path], "thread").model.name == "thread"


def test_a_spring_is_told_behind_clipping_and_beside_a_file_that_cannot_be_fitted(tmp_path):
    times = np.arange(0.0, 60.0, 0.01)
    angle = 1.4 * np.exp(-0.02 * times) * np.cos(2.0 * np.pi * 1.2 * times)
    angle = np.clip(angle + np.random.default_rng(7).normal(0.0, 1e-3, times.size), -1.1, 1.1)
    path = tmp_path / "swing.csv"
    np.savetxt(path, np.column_stack([times, angle]), delimiter=",", header="time_s,phi_rad", comments="")
    assert load_diagnosis_input([path]).model.name == "thread_small_angle"


def test_a_base_takes_the_place_of_the_variant():
    assert load_diagnosis_input([THREAD], base="thread+quadratic_drag").model.name == "thread+quadratic_drag"
    with pytest.raises(InputError, match="no variant 'nonsense'"):
        load_diagnosis_input([THREAD], base="nonsense")


def test_volts_without_sensitivity_are_shots_of_volts(tmp_path):
    path = without(tmp_path, "calibration")
    found = load_diagnosis_input([path])
    assert [(s.record.quantity, s.unit, s.sensitivity) for s in found.shots] == [("voltage", "V", None)] * 2
    assert ABSORBED in found.notes
    with pytest.raises(RecordingError, match=r"has no sensitivity.*--calibration"):
        load_diagnosis_input([path], observable="dmdt")


def test_files_of_different_resonators_are_refused_whatever_is_asked_for():
    for variant in (None, "thread"):
        with pytest.raises(InputError, match=r"different resonators.*jewel.*thread"):
            load_diagnosis_input([THREAD, JEWEL], variant)


def test_a_file_that_does_not_say_its_variant_needs_one_named(tmp_path):
    path = without(tmp_path, "resonator")
    with pytest.raises(RecordingError, match="--variant"):
        load_diagnosis_input([path])
    assert load_diagnosis_input([path], "thread").model.name == "thread"


def test_the_wrong_observable_is_refused_with_the_remedy():
    with pytest.raises(RecordingError, match=r"as an angle \(--observable"):
        load_diagnosis_input([PENDULUM], observable="dmdt")
    with pytest.raises(RecordingError, match="/time"):
        load_diagnosis_input([THREAD], observable="angle")


def test_a_frame_with_nan_is_left_out_and_said(tmp_path):
    path = copied(tmp_path)
    with h5py.File(path, "r+") as file:
        file["data"][0, 1, 5000] = np.nan
    found = load_diagnosis_input([path])
    assert [s.name for s in found.shots] == ["copy.h5 frame 1"]
    assert any("copy.h5 frame 0 was left out" in n for n in found.notes)


def test_a_clipped_frame_is_a_flaw_and_no_shot(tmp_path):
    path = copied(tmp_path)
    with h5py.File(path, "r+") as file:
        data = file["data"][0]
        limit = np.abs(data[:, -data.shape[1] // 4 :]).max()
        file["data"][0] = np.clip(data, -limit, limit)
    found = load_diagnosis_input([path])
    assert [f.id for f in found.flaws] == ["saturation"]
    assert len(found.shots) == 1


def test_uneven_clocks_become_flaws(tmp_path):
    t, angle = swing()
    t[2000:] += 3 / 400.0
    found = load_diagnosis_input([pendulum(tmp_path, t, angle)])
    assert [f.id for f in found.flaws] == ["clock_gap"]


def test_files_without_a_usable_shot_say_why(tmp_path):
    t, angle = swing()
    angle[7] = np.inf
    with pytest.raises(NothingToDiagnoseError, match="not_finite: 1 samples, the first is 7 "):
        load_diagnosis_input([pendulum(tmp_path, t, angle)])


@pytest.mark.long
def test_of_a_long_series_some_are_searched_and_the_others_tried_one_by_one(tmp_path, monkeypatch):
    monkeypatch.setattr("platform_daemon.features.diagnose.shot_reading._MOST_SEARCHED", 1)
    files = [THREAD, copied(tmp_path), copied(tmp_path, name="third.h5")]
    specimen = load_diagnosis_input(files)
    assert [s.name for s in specimen.shots] == [
        f"{THREAD.name} frame 0", "copy.h5 frame 0", "copy.h5 frame 1", "third.h5 frame 1"
    ]  # fmt: skip
    assert [load().name for load in specimen.further] == [f"{THREAD.name} frame 1", "third.h5 frame 0"]
    seen: list[float] = []
    found = diagnose_input(specimen, lambda what, share: seen.append(share))
    (note,) = [n for n in found.notes if n.startswith("2 shots that were not searched")]
    before, after = map(float, re.findall(r"chi2/dof ([\d.]+) with the declared model, ([\d.]+) with", note)[0])
    assert 0.9 < after <= before < 1.1
    assert seen == sorted(seen)
    assert any("of 6 shots 4, evenly spread, are searched" in n for n in found.notes)
