"""Tune: f_nat from far away and from too little, the sequence that follows, its preset, and what never rings."""

import math

import pytest

from drivers.errors import InputError, SequenceRejected
from platform_daemon.core.jobs.jobs import JobState
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.features.acquire.destination import OwnFile
from platform_daemon.features.acquire.series_plan import plan_series, series_work
from platform_daemon.features.procedures.schema import ProcedureLog
from platform_daemon.features.tune.schema import TunedPreset
from platform_daemon.features.tune.work import MOST_SHOTS, NothingRings
from tests.kit.tunes import DESIGN_HZ, off_design, tune_work, tuned

DAY_HZ = 0.2  # what a day's temperature does to f_nat of the simulated platform, two standard deviations


def test_a_jewel_15_percent_above_its_design_is_tuned_and_its_preset_is_used_from_then_on(engine_with, tmp_path):
    engine, true_hz = engine_with(), 1.15 * DESIGN_HZ
    own = off_design(tmp_path, "jewel", true_hz)
    job = tuned(engine, tmp_path, own)
    assert job.state is JobState.DONE, job.error
    found = job.result.outcome
    assert found.design_f_nat_hz == pytest.approx(DESIGN_HZ, abs=0.01)
    assert found.f_nat_hz.value == pytest.approx(true_hz, abs=DAY_HZ)
    assert found.shots == len(job.result.steps) <= MOST_SHOTS
    # The preset's field times periods is the most that any shot excites with.
    assert all(s.values[1].value * s.values[2].value <= 4900.1 for s in job.result.steps)
    keys = found.sequence
    assert (keys.field_t, keys.axis) == (490e-6, "x")
    assert 1 <= keys.tx_periods <= 10
    assert 0.97 * true_hz < keys.f_tx_hz < true_hz
    assert keys.rx_s > found.d30_s > 0.25
    recording = open_recording(tmp_path / "t.h5")
    assert recording.frames == found.shots
    assert recording.provenance.incomplete is None
    assert ProcedureLog.model_validate_json((tmp_path / "t.json").read_text()).result == job.result

    assert found.preset == "own-jewel@1"
    kept = TunedPreset.model_validate_json((tmp_path / "presets" / "own-jewel@1.json").read_text())
    assert (kept.procedure, kept.recording) == (job.identifier, "t.h5")
    plan = plan_series(engine, AcquisitionRequest(resonator=own))
    assert (plan.sequence.f_tx_hz, plan.sequence.rx_s) == (keys.f_tx_hz, keys.rx_s)
    assert (
        plan_series(
            engine, AcquisitionRequest.model_validate({"resonator": own, "sequence": {"rx_s": 3.0}})
        ).sequence.rx_s
        == 3.0
    )
    # Measured with it, the magnet swings as far as was expected.
    made = engine.submit(series_work(engine, plan, OwnFile(tmp_path / "m.h5", tmp_path)))
    assert made.ended.wait(timeout=60)
    assert made.result.fit.frames[0].values["phi_max_rad"] == pytest.approx(found.swing_rad, rel=0.15)

    # Another declaration under the same name is another resonator.
    off_design(tmp_path, "jewel", 200.0)
    other = plan_series(engine, AcquisitionRequest(resonator=own))
    assert other.sequence.f_tx_hz == 212.0
    assert "own-jewel@1" in other.warnings[0]


def test_where_the_first_answer_is_too_weak_for_a_fit_the_line_is_enough_to_go_on_with_more_field(
    engine_with, tmp_path
):
    true_hz = 0.85 * DESIGN_HZ
    job = tuned(engine_with(), tmp_path, off_design(tmp_path, "thread", true_hz), weak_field_t=2e-6)
    assert job.state is JobState.DONE, job.error
    first = job.result.steps[0]
    assert first.reason.startswith("amplitude_below_floor")
    assert first.heard.frequency_hz == pytest.approx(true_hz, abs=1.0)
    found = job.result.outcome
    assert found.f_nat_hz.value == pytest.approx(true_hz, abs=DAY_HZ)
    assert found.fields_t[0] == 2e-6 < found.fields_t[1]
    assert found.shots <= MOST_SHOTS
    # At rest when the next shot begins, and heard until it is in the noise.
    assert found.sequence.rx_s + found.sequence.pause_s > math.log(100) / found.lambda_per_s.value
    assert found.swing_rad_per_t == pytest.approx(11.014e-3 / 9.9243e-11 / (4 * math.pi * true_hz**2), rel=0.05)


def test_what_never_rings_is_told_after_three_shots_and_keeps_no_preset(engine_with, tmp_path):
    job = tuned(engine_with(), tmp_path, "thread", sequence={"axis": "z"})
    assert job.state is JobState.FAILED
    assert isinstance(job.error, NothingRings)
    assert "sequence.axis" in job.error.remedy
    assert len(job.result.steps) == job.result.outcome.shots == 3
    assert list(job.result.outcome.fields_t) == sorted(job.result.outcome.fields_t)
    assert open_recording(tmp_path / "t.h5").frames == 3
    assert not (tmp_path / "presets").exists()


def test_the_plan_tells_the_search_and_at_most_five_shots_and_nothing_moves(engine_with, tmp_path):
    engine = engine_with()
    plan = tune_work(engine, tmp_path, "jewel", max_field_t=3e-4).summary()
    assert plan.shots == len(plan.steps) == MOST_SHOTS
    assert {value.key for step in plan.steps for value in step.values} == {"f_tx_hz", "tx_periods", "field_ut"}
    assert max(step.values[2].value for step in plan.steps) == 300.0
    assert engine.platform.backends["simulated"].world.shots == 0


@pytest.mark.parametrize(
    ("keys", "error", "word"),
    [
        ({"weak_field_t": 9e-4, "max_field_t": 5e-4}, InputError, "weak_field_t"),
        ({"sequence": {"field_t": 2e-3}}, SequenceRejected, "max_field_t"),
        ({"sequence": {"f_tx_hz": 15.0}}, SequenceRejected, "max_tx_s"),
    ],
)
def test_what_cannot_be_is_told_before_anything_moves(engine_with, tmp_path, keys, error, word):
    with pytest.raises(error) as found:
        tune_work(engine_with(), tmp_path, "jewel", **keys)
    assert word in str(found.value)
    assert found.value.remedy
