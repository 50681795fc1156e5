"""Sweeps on the simulated platform: one recording, repeats, pauses, cancel, and what is refused before it begins."""

import itertools
import time

import pytest

from drivers.errors import ConfigError, DeviceFault, DeviceStateError, InputError, SequenceRejected
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.staging import folder_of
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.schemas.requests import ActivationRequest
from platform_daemon.core.settings import load_platform
from platform_daemon.features.procedures.conductor import PauseTooLong
from platform_daemon.features.procedures.schema import ProcedureLog
from platform_daemon.processes.assembly import start_engine
from tests.kit.acquisitions import acquire
from tests.kit.fit_tables import read_fits
from tests.kit.sweeps import FIELDS, sweep_work, swept


@pytest.fixture(scope="module")
def idle_engine():
    """For what is refused before anything moves."""
    engine = start_engine(load_platform("simulated"))
    yield engine
    assert engine.job_ids("acquisition") == ()
    assert engine.platform.backends["simulated"].world.shots == 0
    engine.close()


def log_of(folder):
    return ProcedureLog.model_validate_json((folder / "s.json").read_text())


def until(condition):
    deadline = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.005)


def test_the_shots_of_all_steps_are_in_one_recording_grouped_by_step_with_their_fits(engine_with, tmp_path):
    engine = engine_with()
    job = swept(engine, tmp_path, {"key": "field_ut", "start": 250, "stop": 350, "step": 100}, shots=2, window="n50")
    assert job.state is JobState.DONE, job.error
    assert job.result.stopped == "every step was made"
    recording = open_recording(tmp_path / "s.h5")
    assert [i.step.label.number for i in recording.frame_info] == [1, 1, 2, 2]
    assert [i.step.label.values["field_ut"] for i in recording.frame_info] == [250.0, 250.0, 350.0, 350.0]
    assert [i.excitation.field_t for i in recording.frame_info] == pytest.approx([250e-6] * 2 + [350e-6] * 2)
    assert recording.provenance.incomplete is None
    first, second = job.result.steps
    assert (first.frames, second.frames) == ((0, 1), (2, 3))
    assert first.results["phi_max_rad"].median < second.results["phi_max_rad"].median
    assert (first.verdict, first.fitted, first.complete) == ("good", 2, True)
    (table,) = read_fits(tmp_path / "s.h5")
    at = table.parameters.index("f_nat_hz")
    assert table.values[2:, at].mean() == pytest.approx(second.results["f_nat_hz"].median, rel=1e-12)
    assert log_of(tmp_path).result == job.result
    assert not folder_of(tmp_path / "s.h5").exists()
    # Each step is an acquisition like anybody's.
    assert list(engine.job_ids("acquisition")) == [a for s in job.result.steps for a in s.acquisitions]


def test_a_rule_ends_it_after_the_first_step_that_meets_it_and_the_recording_says_so(engine_with, tmp_path):
    rule = {"result": "phi_max_deg", "comparison": ">", "value": 25}
    job = swept(engine_with(), tmp_path, stop_when=rule, window="n50")
    assert job.state is JobState.DONE, job.error
    assert [s.values[0].value for s in job.result.steps] == [200, 300]
    assert job.progress().fraction == 1.0
    assert job.result.stopped == "phi_max_deg > 25 in step 2"
    assert open_recording(tmp_path / "s.h5").provenance.incomplete.startswith("stopped after 2 of 3 steps: phi_max_deg")


def test_a_rule_that_no_step_meets_is_said_not_to_be_met(engine_with, tmp_path):
    rule = {"result": "phi_max_deg", "comparison": ">", "value": 89}
    job = swept(engine_with(), tmp_path, {"key": "field_ut", "values": [250]}, stop_when=rule, window="n50")
    assert job.result.stopped == "every step was made; phi_max_deg > 89 in none of them"


def test_of_several_keys_all_combinations_are_made_and_frames_of_different_windows_share_a_recording(
    engine_with, tmp_path
):
    job = swept(
        engine_with(), tmp_path, {"key": "f_tx_hz", "values": [200, 212]}, {"key": "rx_ms", "values": [200, 250]}
    )
    assert job.state is JobState.DONE, job.error
    said = [tuple(v.value for v in s.values) for s in job.result.steps]
    assert said == list(itertools.product([200, 212], [200, 250]))
    recording = open_recording(tmp_path / "s.h5")
    rate, start = recording.sequence.rate_hz, recording.sequence.rx_start
    for k, (f_hz, rx_ms) in enumerate(said):
        info, volts = recording.frame_info[k], recording.frame_volts(k)
        assert recording.rx_volts(k).shape[1] == info.step.rx_samples == pytest.approx(rx_ms * 1e-3 * rate, abs=1)
        assert info.step.tx_samples == pytest.approx(10 / f_hz * rate, abs=1)
        lead = start - info.step.tx_samples - info.step.switch_samples
        assert not volts[:, :lead].any()
        assert volts[:, lead].any() or lead == 0
        assert not volts[:, info.valid_samples :].any()
        assert recording.rx_volts(k)[:, -1].any()


def test_a_refused_shot_is_kept_marked_and_made_again(engine_with, tmp_path):
    engine = engine_with("backends.simulated.faults.lost_steps=[2]")
    job = swept(engine, tmp_path)
    assert job.state is JobState.DONE, job.error
    assert [(s.frames, s.refused) for s in job.result.steps] == [((0,), 0), ((1, 2), 1), ((3,), 0)]
    infos = open_recording(tmp_path / "s.h5").frame_info
    assert [(i.step.label.number, i.verdict) for i in infos] == [(1, "good"), (2, "refused"), (2, "good"), (3, "good")]
    assert len(job.result.steps[1].acquisitions) == 2
    assert job.progress().done == job.total == 3


def test_a_step_whose_shots_are_refused_again_and_again_ends_it_with_what_there_is(engine_with, tmp_path):
    job = swept(engine_with("backends.simulated.faults.overwritten=[2,3,4]"), tmp_path)
    assert job.state is JobState.FAILED
    assert isinstance(job.error, DeviceFault)
    assert job.error.where == "step 2 (field_ut = 300)"
    assert "overwritten" in job.error.why
    assert job.error.remedy
    assert [(s.verdict, s.complete) for s in job.result.steps] == [("good", True), ("refused", False)]
    recording = open_recording(tmp_path / "s.h5")
    assert [i.verdict for i in recording.frame_info] == ["good", *["refused"] * 3]
    assert recording.provenance.incomplete.startswith("stopped after 1 of 3 steps: failed: step 2")
    assert log_of(tmp_path).result.stopped.startswith("failed: step 2 (field_ut = 300): shots were refused")


def test_a_device_that_fails_in_the_middle_is_told_with_its_step(engine_with, tmp_path):
    engine = engine_with("backends.simulated.faults.card_timeout=[2]")
    job = swept(engine, tmp_path)
    assert job.state is JobState.FAILED
    assert job.error.where.startswith("step 2 (field_ut = 300)")
    assert open_recording(tmp_path / "s.h5").frames == 1
    assert not engine.platform.amplifier.status().can_put_out_power


@pytest.mark.long
def test_a_pause_rests_between_shots_with_outputs_off_lets_others_measure_and_goes_on(engine_with, tmp_path):
    engine = engine_with()
    job = engine.submit(sweep_work(engine, tmp_path, shots=6))
    seen = []
    until(lambda: seen.append(job.progress().done) or job.progress().done > 2)
    job.pause_requested.set()
    until(lambda: job.phase == "paused")
    assert job.state is JobState.RUNNING
    assert job.progress().time_left_s is None
    assert not engine.platform.amplifier.status().enabled
    assert engine.status().running is None
    assert engine.status().queued == ()
    made = open_recording(max(folder_of(tmp_path / "s.h5").glob("shot_*.h5"))).frame_info[0].shot
    assert 2 <= made < 18
    assert acquire(engine, tmp_path / "other.h5", window=None).state is JobState.DONE
    with pytest.raises(DeviceStateError, match="procedure"):  # it goes on with the calibration that it began with
        engine.activate(ActivationRequest(kind="receive"), tmp_path)
    job.pause_requested.clear()
    until(lambda: seen.append(job.progress().done) or job.ended.is_set())
    assert job.state is JobState.DONE, job.error
    assert seen == sorted(seen)
    infos = open_recording(tmp_path / "s.h5").frame_info
    assert [i.step.label.number for i in infos] == [1] * 6 + [2] * 6 + [3] * 6
    # A step that was paused took two; a pause between two steps cut none.
    assert sum(len(s.acquisitions) for s in job.result.steps) == (3 if made % 6 == 0 else 4)


def test_a_pause_that_outlasts_its_limit_ends_it_with_what_there_is(engine_with, tmp_path):
    engine = engine_with()
    work = sweep_work(engine, tmp_path, longest_pause_s=0.1)
    job = engine.submit(work)
    until(lambda: job.result.steps)
    job.pause_requested.set()
    assert job.ended.wait(timeout=60)
    assert isinstance(job.error, PauseTooLong)
    assert job.error.where == "longest_pause_s"
    assert job.error.remedy
    assert open_recording(tmp_path / "s.h5").frames >= 1


@pytest.mark.long
@pytest.mark.parametrize("how", ["cancel", "cancel the step", "stop", "close", "cancel in a pause"])
def test_whatever_stops_it_the_shots_on_disk_are_put_together_and_nothing_moves_any_more(engine_with, tmp_path, how):
    engine = engine_with()
    job = engine.submit(sweep_work(engine, tmp_path, shots=50))
    until(lambda: job.progress().done > 1)
    if how == "cancel in a pause":
        job.pause_requested.set()
        until(lambda: job.phase == "paused")
    actions = {"stop": engine.outputs_off, "close": engine.close}
    steps = [engine.job("acquisition", each) for each in engine.job_ids("acquisition")]
    actions.get(how, steps[-1].request_cancel if how == "cancel the step" else job.request_cancel)()
    assert job.ended.wait(timeout=60)
    assert job.state is JobState.CANCELLED
    assert all(step.ended.wait(timeout=60) for step in steps)
    recording = open_recording(tmp_path / "s.h5")
    assert recording.frames == len(job.result.steps[0].frames)
    assert recording.provenance.incomplete == "stopped after 0 of 3 steps: cancelled"
    assert log_of(tmp_path).result.stopped == "cancelled"
    assert not engine.platform.amplifier.status().enabled
    assert engine.platform.backends["simulated"].world.violations() == ()


def test_of_two_procedures_the_second_waits_and_an_acquisition_takes_its_turn_between_steps(engine_with, tmp_path):
    engine = engine_with()
    (tmp_path / "b").mkdir()
    first = engine.submit(sweep_work(engine, tmp_path))
    second = engine.submit(sweep_work(engine, tmp_path / "b"))
    assert second.state is JobState.QUEUED
    assert acquire(engine, tmp_path / "a.h5", window=None).state is JobState.DONE
    assert second.ended.wait(timeout=60)
    assert first.state is second.state is JobState.DONE
    assert first.finished <= second.started


def test_the_wait_between_shots_is_kept_between_steps_too(engine_with, tmp_path):
    job = swept(engine_with(), tmp_path, sequence={"rx_s": 0.2, "pause_s": 5.0})
    assert job.state is JobState.DONE, job.error
    times = [i.monotonic_s for i in open_recording(tmp_path / "s.h5").frame_info]
    assert all(later - earlier > 5.0 for earlier, later in itertools.pairwise(times))


def test_a_rule_on_what_this_model_has_not_ends_it_after_one_step(engine_with, tmp_path):
    rule = {"result": "quadratic_drag_per_rad", "comparison": ">", "value": 1}
    job = swept(engine_with(), tmp_path, stop_when=rule, window="n50")
    assert job.state is JobState.FAILED
    assert "tf_over_i_rad_per_s2" in job.error.remedy
    assert len(job.result.steps) == 1
    assert open_recording(tmp_path / "s.h5").frames == 1


def test_the_plan_says_steps_shots_duration_and_disk_and_nothing_moves(idle_engine, tmp_path):
    plan = sweep_work(idle_engine, tmp_path, {"key": "shots", "values": [1, 3]}, blank_shots=1).summary()
    assert [step.shots for step in plan.steps] == [2, 4]
    assert plan.shots == 6
    assert plan.duration_s == pytest.approx(sum(step.duration_s for step in plan.steps))
    assert plan.disk_bytes > 6 * 0.3 * 61000 * 3 * 4


@pytest.mark.parametrize(
    ("over", "error", "words"),
    [
        ({"key": "field_ut", "values": [200, 2000]}, SequenceRejected, ("step 2 (field_ut = 2000)", "max_field_t")),
        ({"key": "field_ut", "values": [200, -1]}, ConfigError, ("step 2 (field_ut = -1)", "sequence.field_t")),
        ({"key": "sequence.tx_periods", "values": [9.5]}, ConfigError, ("step 1", "whole number")),
        ({"key": "fields", "values": [1]}, InputError, ("no key", "sequence.field_t", "field_ut")),
        ({"key": "resonator", "values": ["jewel", "thread"]}, InputError, ("one resonator",)),
        ({"key": "variant", "values": ["jewel", "wood"]}, InputError, ("step 2 (variant = wood)",)),
    ],
)
def test_what_no_step_can_be_is_told_by_its_number_and_nothing_moves(idle_engine, tmp_path, over, error, words):
    with pytest.raises(error) as found:
        sweep_work(idle_engine, tmp_path, over)
    for word in words:
        assert word in str(found.value)
    assert found.value.remedy


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"stop_when": {"result": "phi", "comparison": ">", "value": 1}}, ("phi_max_rad", "phi_max_deg")),
        ({"stop_when": {"result": "r2", "comparison": ">", "value": 1}}, ("without on-line fits", "window")),
    ],
)
def test_a_rule_on_what_there_is_not_is_told_before_it_begins(idle_engine, tmp_path, keys, words):
    with pytest.raises(InputError) as found:
        sweep_work(idle_engine, tmp_path, **keys)
    for word in words:
        assert word in str(found.value)


def test_a_key_under_two_names_and_a_recording_that_exists_are_refused(idle_engine, tmp_path):
    with pytest.raises(InputError, match="twice"):
        sweep_work(idle_engine, tmp_path, FIELDS, {"key": "sequence.field_t", "values": [1e-4]})
    (tmp_path / "s.h5").touch()
    with pytest.raises(InputError, match="exists already"):
        sweep_work(idle_engine, tmp_path)
