"""A manufacturing error becomes a model; what cannot use it says so, and never takes one angle in its place."""

import pytest

from drivers.errors import InputError
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.features.diagnose.adoption import AdoptionRefused, model_from_diagnosis
from platform_daemon.features.fit.fit import fit_frame_of
from platform_daemon.features.fit.fit_request import FitRequest, check_fixed
from platform_daemon.features.fit.measurement import VoltageMeasurement
from platform_daemon.features.fit.online import OnlineFit, checked_model
from platform_daemon.features.models.library import Library
from platform_daemon.features.models.resolve import model_of, notes_of
from tests.kit.data import DATA
from tests.kit.diagnosis_json import diagnosed, effect
from tests.kit.recording_files import write_minimal

HELD = {"distance_m": 4.45e-3, "side_damping_per_s": 22.0, "friction_coefficient": 0.0, "creep_m_per_s": 0.0}
TILT = effect("stator_tilt", 8.7e-4, "rad", **HELD)


@pytest.fixture
def library(tmp_path):
    return Library(tmp_path / "models")


def tilted(library, *effects, **options):
    said = diagnosed(*(effects or [TILT]), lambda_per_s=0.25)
    return library.add(model_from_diagnosis(said, "tilted", "me", library, recordings=[], **options))


def test_a_manufacturing_error_is_kept_with_what_belongs_to_it_and_its_digest_depends_on_it(library):
    made = tilted(library)
    other = tilted(library, effect("rotor_tilt", 8.7e-4, "rad", **HELD))
    read = library.get("tilted@1")
    assert read == made
    assert (read.rotor.parameter, other.rotor.parameter) == ("stator_tilt_rad", "bearing_tilt_rad")
    assert read.rotor.strength == 8.7e-4
    assert read.rotor.held == HELD
    assert len({made.digest, other.digest, made.one_angle.digest}) == 3
    assert "stator_tilt held" in notes_of(read)[0]
    assert read.summary().terms == ("stator_tilt",)


def test_what_takes_one_angle_refuses_it_with_a_remedy(library):
    made = tilted(library)
    with pytest.raises(InputError, match="cannot be used here") as refused:
        model_of(made)
    assert "stator_tilt" in refused.value.why
    assert "fit --variant tilted@1" in refused.value.remedy
    assert model_of(made.one_angle).losses == ("lambda_per_s",)


def test_a_series_takes_it_and_a_shot_without_a_known_drive_says_what_to_do(library):
    tilted(library)
    model = checked_model("tilted", library.folder)
    assert (model.label, model.of_rotor) == ("tilted@1", True)
    file = DATA / "example_thread.mmr.h5"
    calibration = open_recording(file).calibration
    found = OnlineFit(file, calibration, model, 0.2, None, None, blank=False, noise=None)(lambda done, what: None)
    assert found.frame.verdict == "refused"
    assert "tilted@1 cannot be used on-line" in found.frame.reason
    assert "fit the recording: platform-daemon fit --variant tilted@1" in found.frame.reason
    assert not (library.folder / "corrections").exists()


def test_a_number_that_is_missing_in_the_diagnosis_is_named(library):
    short = effect("stator_tilt", 8.7e-4, "rad", **{**HELD, "distance_m": None})
    with pytest.raises(InputError, match="missing") as refused:
        tilted(library, short)
    assert "distance_m" in refused.value.where


def test_it_is_held_and_takes_no_torque_beside_it(library):
    with pytest.raises(AdoptionRefused, match="cannot be free"):
        tilted(library, free=["stator_tilt"])
    tilted(library)
    said = diagnosed(effect("coulomb_friction", 30.0), model="tilted@1")
    with pytest.raises(AdoptionRefused, match="rotor"):
        model_from_diagnosis(said, "both", "me", library, recordings=[])


def test_a_recording_without_its_drive_begins_in_any_state_and_a_hint_is_refused(library):
    made = tilted(library)
    measurement = VoltageMeasurement.of(open_recording(DATA / "example_thread.mmr.h5"))
    ask = FitRequest(made, hold_if_inseparable={"lambda_per_s": 0.25})
    check_fixed(ask, calibrated=True)
    with pytest.raises(InputError, match="cannot be used here") as refused:
        fit_frame_of(measurement, 0, ask)
    assert "leave --hint" in refused.value.remedy
    found = fit_frame_of(measurement, 0, FitRequest(made, window=0.2))
    assert found.verdict == "good"
    assert found.chi2_per_dof < 1.1
    assert any("begins in any state" in note for note in found.notes)
    assert any("thread.toml" in note for note in found.notes)


def test_without_a_calibration_there_is_no_rotor(library, tmp_path):
    made = tilted(library)
    volts = write_minimal(tmp_path / "volts.h5", {"/calibration/sensitivity": None})
    with pytest.raises(InputError, match="cannot be used here") as refused:
        fit_frame_of(VoltageMeasurement.of(open_recording(volts)), 0, FitRequest(made))
    assert "calibration" in refused.value.remedy
