"""Ramps on the simulated platform: a resonator with side modes, one without, and one that never rings."""

import math

import pytest

from drivers.errors import InputError, SequenceRejected
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.truth import read_truth
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.core.settings import read_toml
from platform_daemon.features.acquire.series_plan import plan_series
from platform_daemon.features.diagnose.adoption import model_from_diagnosis
from platform_daemon.features.models.library import Library
from platform_daemon.features.procedures.bench import ProcedureBench
from platform_daemon.features.procedures.conductor import ProcedureFiles
from platform_daemon.features.procedures.planned import plan_procedure
from platform_daemon.features.ramp.report import ramp_text
from platform_daemon.features.ramp.schema import RampRequest
from platform_daemon.features.ramp.work import NeverRings
from tests.kit.diagnosis_json import diagnosed, effect


def work(engine, folder, resonator="thread_imperfect", sequence=None, **keys):
    acquisition = {"resonator": resonator, "sequence": {"rx_s": 1.0, "pause_s": 12.0, **(sequence or {})}}
    request = RampRequest.model_validate({"kind": "ramp", "acquisition": acquisition, **keys})
    return plan_procedure(
        ProcedureBench(engine=engine, files=ProcedureFiles(folder, folder, folder / "r.h5", folder / "r.json")), request
    )


def done(engine, planned):
    job = engine.submit(planned)
    assert job.ended.wait(timeout=240)
    return job


@pytest.mark.long
def test_a_ramp_ends_near_the_threshold_of_the_world_and_keeps_it_with_the_specimen(engine_with, tmp_path):
    engine = engine_with()
    job = done(engine, work(engine, tmp_path, start_t=200e-6, max_t=400e-6))
    assert job.state is JobState.DONE, job.error
    found = job.result.outcome
    assert found.threshold_t.value == pytest.approx(270e-6, abs=20e-6)
    assert found.threshold_t.low <= found.threshold_t.value <= found.threshold_t.high
    assert found.operating_field_t == pytest.approx(0.8 * found.threshold_t.value)
    assert found.overshoot_t < 10e-6
    assert {line.near for line in found.lines} >= {"2f"}
    truths = [t["simulated"] for t in read_truth(tmp_path / "r.h5")]
    fields = [i.excitation.field_t for i in open_recording(tmp_path / "r.h5").frame_info]
    for step in found.steps:
        true = [t["z_residual_am2_per_s"] for t, f in zip(truths, fields, strict=True) if math.isclose(f, step.field_t)]
        if step.z_residual_am2_per_s > 0.1:
            assert step.z_residual_am2_per_s == pytest.approx(sum(true) / len(true), rel=0.1)
    # What was found holds from now on.
    kept = tmp_path / "r.toml"
    assert read_toml(kept)[0]["side_modes"]["max_field_t"] == found.max_field_t
    above = {"resonator": str(kept), "sequence": {"field_t": 1.05 * found.max_field_t}}
    with pytest.raises(SequenceRejected, match="side modes"):
        plan_series(engine, AcquisitionRequest.model_validate(above))
    plan_series(engine, AcquisitionRequest.model_validate(above | {"beyond_side_modes": True}))
    with pytest.raises(InputError, match="above the limit"):
        work(engine, tmp_path, str(kept), max_t=400e-6)


TILT = effect(
    "stator_tilt", 8.68e-4, "rad", distance_m=4.4552e-3, side_damping_per_s=21.75, lean_damping_per_s=21.63,
    damping_axis_to_thread=0.2068, creep_m_per_s=0.0, creep_spin_rad_per_s=0.0, creep_law=0.0, contact_coupling=1.0,
    friction_coefficient=0.0,
)  # fmt: skip
"""As a diagnosis of thread_imperfect at 240 uT finds it."""


def adopted(folder, *effects):
    library = Library(folder)
    said = diagnosed(*effects, f_nat_hz=215.586, m_r_am2=11.0085e-3, lambda_per_s=0.24617)
    return library.add(model_from_diagnosis(said, "tilted", "me", library, recordings=[])).label


@pytest.mark.long
def test_the_threshold_that_a_tilt_predicts_stands_beside_the_measured_one(engine_with, tmp_path):
    label = adopted(tmp_path / "models", TILT)
    engine = engine_with(models=tmp_path / "models")
    job = done(engine, work(engine, tmp_path, start_t=240e-6, max_t=320e-6, predicted_by=label))
    assert job.state is JobState.DONE, job.error
    found = job.result.outcome
    assert found.predicted.model == label
    assert found.predicted.why is None
    assert found.predicted.threshold_t == pytest.approx(270e-6, rel=0.05)
    assert found.threshold_t.value == pytest.approx(270e-6, abs=20e-6)
    assert f"{label} predicts" in ramp_text(found)


def test_a_threshold_is_predicted_by_an_error_of_the_same_bearing_only(engine_with, tmp_path):
    tilted = adopted(tmp_path / "models", TILT)
    dry = adopted(tmp_path / "models", effect("coulomb_friction", 1.0, "rad/s^2"))
    engine = engine_with(models=tmp_path / "models")
    with pytest.raises(InputError, match="adopted from a thread"):
        work(engine, tmp_path, "jewel_imperfect", predicted_by=tilted)
    with pytest.raises(InputError, match="holds no manufacturing error"):
        work(engine, tmp_path, predicted_by=dry)
    with pytest.raises(InputError, match="no variant 'nobody'"):
        work(engine, tmp_path, predicted_by="nobody")


@pytest.mark.long
def test_without_side_modes_it_goes_to_the_highest_field_proposes_none_and_keeps_nothing(engine_with, tmp_path):
    engine = engine_with()
    job = done(engine, work(engine, tmp_path, "thread", start_t=260e-6, max_t=290e-6))
    found = job.result.outcome
    assert (found.threshold_t, found.operating_field_t, found.max_field_t) == (None, None, None)
    assert (found.highest_field_t, found.ended_by) == (290e-6, "requested_limit")
    assert found.specimen_file is None
    assert not (tmp_path / "r.toml").exists()
    assert [s.verdict for s in found.steps] == ["below"] * 4
    assert job.result.stopped.startswith("no side modes up to 290 uT, the highest field that was requested")
    said = ramp_text(found)
    assert "no threshold was found up to 290 uT (the highest field that was requested)" in said
    assert "work at" not in said


@pytest.mark.long
def test_a_ramp_at_the_limit_of_the_platform_says_that_it_was_this_limit(engine_with, tmp_path):
    engine = engine_with("limits.max_field_t=2.5e-4")
    job = done(engine, work(engine, tmp_path, "thread", start_t=250e-6))
    found = job.result.outcome
    assert (found.ended_by, found.operating_field_t, found.max_field_t) == ("platform_limit", None, None)
    assert "the limit of the platform" in job.result.stopped


def test_where_coils_and_amplifier_allow_less_than_the_limit_the_ramp_ends_there(engine_with, tmp_path):
    engine = engine_with()
    request = {"resonator": "jewel", "sequence": {"field_t": 505e-6}}
    most_a = plan_series(engine, AcquisitionRequest.model_validate(request)).excited.summary()["peak_current_a"]["x"]
    engine.close()
    limited = engine_with(f"limits.max_coil_current_a={most_a}")
    plan = work(limited, tmp_path, "jewel", start_t=450e-6).summary()
    assert plan.steps[-1].values[0].value == pytest.approx(500.0)


@pytest.mark.long
def test_a_first_field_above_the_threshold_is_told_and_nothing_is_kept(engine_with, tmp_path):
    """Nothing can be fitted there, but it rings."""
    engine = engine_with()
    job = done(engine, work(engine, tmp_path, start_t=320e-6, max_t=400e-6))
    assert job.state is JobState.DONE, job.error
    found = job.result.outcome
    assert (found.threshold_t, found.max_field_t, found.operating_field_t) == (None, None, None)
    assert "start lower" in job.result.stopped
    assert not (tmp_path / "r.toml").exists()


@pytest.mark.long
def test_a_threshold_is_found_from_a_field_at_which_side_modes_stir_already(engine_with, tmp_path):
    engine = engine_with()
    job = done(engine, work(engine, tmp_path, start_t=250e-6, max_t=400e-6))
    assert job.result.outcome.threshold_t.value == pytest.approx(270e-6, abs=20e-6)


@pytest.mark.long
def test_what_never_rings_is_found_out_in_three_shots(engine_with, tmp_path):
    engine = engine_with()
    job = done(engine, work(engine, tmp_path, sequence={"axis": "z"}, start_t=100e-6))
    assert job.state is JobState.FAILED
    assert isinstance(job.error, NeverRings)
    assert "no ring-down in 3 shots" in str(job.error)
    assert open_recording(tmp_path / "r.h5").frames == 3


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"max_t": 0.5}, "above the limit"),
        ({"start_t": 3e-4, "max_t": 2e-4}, "start"),
        ({"step_t": 0.0}, "step_t"),
        ({"step_t": 1e-21}, "step_t"),
        ({"start_t": 5e-324, "step_t": 1e-9}, "more than 1000 steps"),
    ],
)
def test_fields_that_cannot_be_are_refused_before_anything_moves(engine_with, tmp_path, keys, said):
    with pytest.raises((InputError, ValueError), match=said):
        work(engine_with(), tmp_path, **keys)
