import json
import time

import h5py
import numpy as np
import pytest

from drivers.errors import DeviceError, InterlockError, OutputsUnconfirmed, SequenceRejected, ShotRefused
from drivers.tx_rx_switch import SwitchPosition
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recorded_fits import read_fit
from platform_daemon.core.recordings.truth import read_truth
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.features.acquire.destination import OwnFile
from platform_daemon.features.acquire.series_plan import plan_series, series_work
from platform_daemon.features.fit.fit import fit_measurement
from platform_daemon.features.fit.fit_request import FitRequest
from platform_daemon.features.fit.measurement import open_measurement
from tests.kit.acquisitions import SHORT_JEWEL, acquire
from tests.kit.fit_tables import read_fits
from tests.kit.stored_jobs import job_texts


def assert_everything_off(engine):
    assert not engine.platform.amplifier.status().enabled
    assert engine.platform.switch.position() is SwitchPosition.TRANSMIT
    assert engine.platform.backends["simulated"].world.violations() == ()


def test_a_series_is_stored_fitted_and_ends_with_outputs_off(engine_with, tmp_path):
    engine = engine_with()
    job = acquire(engine, tmp_path / "a.h5", shots=2, sample="S1", operator="me", comment="why")
    assert job.state is JobState.DONE, job.error
    recording = open_recording(tmp_path / "a.h5")
    assert recording.frames == 2
    assert recording.provenance.sample_name == "S1"
    assert [i.verdict for i in recording.frame_info] == ["good", "good"]
    truths = [next(iter(t.values())) for t in read_truth(tmp_path / "a.h5")]
    for frame, truth in zip(job.result.fit.frames, truths, strict=True):
        assert frame.verdict == "good"
        for name, found in frame.parameters.items():
            assert abs(found.value - truth[name]) < 5 * found.std, name
    assert_everything_off(engine)


def test_on_line_fits_are_stored_with_their_covariance(engine_with, tmp_path):
    job = acquire(engine_with(), tmp_path / "a.h5", shots=1)
    table = next(t for t in read_fits(tmp_path / "a.h5") if t.name == "d30")
    parameters = job.result.fit.frames[0].parameters
    assert dict(zip(table.parameters, table.values[0], strict=True)) == pytest.approx(
        {n: p.value for n, p in parameters.items()}
    )
    np.testing.assert_allclose(np.sqrt(np.diag(table.covariance[0])), table.std[0])


def test_the_recording_holds_request_and_realised_values_and_the_exact_windows(engine_with, tmp_path):
    acquire(engine_with(), tmp_path / "a.h5")
    recording = open_recording(tmp_path / "a.h5")
    excitation = recording.frame_info[0].excitation
    assert excitation.requested_hz == 212.0
    assert excitation.realised_hz == pytest.approx(212.00124, abs=1e-5)
    assert excitation.field_t == 490e-6
    assert recording.sequence.tx_samples == 2879
    assert recording.frame_volts(0).shape == (3, recording.sequence.total)
    assert "[limits]" in recording.configuration_toml()


def test_blank_shots_come_first_and_hold_noise_only(engine_with, tmp_path):
    job = acquire(engine_with(), tmp_path / "a.h5", shots=1, blank_shots=1)
    recording = open_recording(tmp_path / "a.h5")
    assert [i.blank for i in recording.frame_info] == [True, False]
    assert [f.verdict for f in job.result.fit.frames] == ["blank", "good"]
    assert read_fit(recording, "d30").verdict == ("blank", "good")
    blank, shot = (recording.rx_volts(k) for k in (0, 1))
    assert np.std(blank[0]) < 0.05 * np.std(shot[0])


def test_fits_of_a_series_use_the_noise_of_its_blank_shots(engine_with, tmp_path):
    job = acquire(engine_with(), tmp_path / "a.h5", shots=2, blank_shots=2)
    on_line = job.result.fit
    assert [f.noise.source for f in on_line.frames] == [None, None, "2 blank shots", "2 blank shots"]
    stored = fit_measurement(open_measurement(tmp_path / "a.h5"), FitRequest("jewel", "d30"))
    assert stored.noise.source == "2 blank shots"
    assert stored.noise.seconds > 0.0
    for first, again in zip(on_line.frames[2:], stored.frames[2:], strict=True):
        assert first.values["f_nat_hz"] == pytest.approx(again.values["f_nat_hz"], rel=1e-9)


def test_fits_of_a_series_without_blank_shots_share_what_stands_beside_the_signals(engine_with, tmp_path):
    acquire(engine_with(), tmp_path / "a.h5", shots=3)
    stored = fit_measurement(open_measurement(tmp_path / "a.h5"), FitRequest("jewel", "n50"))
    assert {f.noise.source for f in stored.frames} == {"3 shots, outside the harmonics"}


def test_a_fit_whose_moment_is_not_the_resonators_says_so(engine_with, tmp_path):
    plain = acquire(engine_with(), tmp_path / "a.h5")
    assert not any("moment" in w for w in plain.result.fit.frames[0].warnings)
    with h5py.File(tmp_path / "a.h5") as source, h5py.File(tmp_path / "cal.h5", "w") as target:
        source.copy("calibration", target)
        target["calibration/sensitivity"][...] *= 40
    off = acquire(engine_with(f'calibration={{file="{tmp_path / "cal.h5"}"}}'), tmp_path / "b.h5")
    (frame,) = off.result.fit.frames
    assert frame.good
    (said,) = (w for w in frame.warnings if w.startswith("moment_implausible"))
    assert ", 0.025 times the 12.03 mAm² that are known of this resonator" in said


def test_cancel_ends_a_running_series_with_outputs_off_and_keeps_its_shots(engine_with, tmp_path):
    engine = engine_with()
    request = AcquisitionRequest(**SHORT_JEWEL, shots=500)
    job = engine.submit(series_work(engine, plan_series(engine, request), OwnFile(tmp_path / "a.h5", tmp_path)))
    while job.progress().done < 2:
        time.sleep(0.02)
    job.request_cancel()
    assert job.ended.wait(timeout=60)
    assert job.state is JobState.CANCELLED
    recording = open_recording(tmp_path / "a.h5")
    assert recording.frames == job.result.shots >= 2
    assert "500" in recording.provenance.incomplete
    assert_everything_off(engine)


def test_a_queued_job_can_be_cancelled_before_its_turn(engine_with, tmp_path):
    engine = engine_with()
    plan = plan_series(engine, AcquisitionRequest(**SHORT_JEWEL, shots=3))
    first, second = (engine.submit(series_work(engine, plan, OwnFile(tmp_path / f"{n}.h5", tmp_path))) for n in "ab")
    assert second.state is JobState.QUEUED
    second.request_cancel()
    assert first.ended.wait(timeout=60)
    assert (first.state, second.state) == (JobState.DONE, JobState.CANCELLED)
    assert not (tmp_path / "b.h5").exists()


@pytest.mark.long
@pytest.mark.parametrize(
    "fault", ["overwritten", "corrupted", "lost_steps", "dropped_samples", "lna_overload", "adc_clip", "relay_bounce"]
)
def test_a_flagged_shot_is_kept_refused_and_the_series_goes_on(engine_with, tmp_path, fault):
    engine = engine_with(f"backends.simulated.faults.{fault}=[2]")
    job = acquire(engine, tmp_path / "a.h5", shots=3)
    assert job.state is JobState.DONE, job.error
    infos = open_recording(tmp_path / "a.h5").frame_info
    assert [i.verdict for i in infos] == ["good", "refused", "good"]
    assert infos[1].reason
    assert job.result.fit.frames[1].parameters == {}
    assert any("shot 2 refused" in w for w in job.warnings)
    assert_everything_off(engine)


@pytest.mark.parametrize("fault", ["card_timeout", "amplifier_trip", "switch_stuck"])
def test_a_failing_device_ends_the_series_with_outputs_off_and_keeps_what_was_stored(engine_with, tmp_path, fault):
    engine = engine_with(f"backends.simulated.faults.{fault}=[2]")
    job = acquire(engine, tmp_path / "a.h5", shots=3)
    assert job.state is JobState.FAILED
    assert isinstance(job.error, DeviceError)
    assert job.error.remedy
    assert open_recording(tmp_path / "a.h5").frames == 1
    assert not engine.platform.amplifier.status().can_put_out_power
    assert engine.platform.backends["simulated"].world.violations() == ()


def test_a_platform_that_cannot_be_switched_off_makes_no_further_shot_until_it_can(engine_with, tmp_path, monkeypatch):
    engine = engine_with()
    world, amplifier = engine.platform.backends["simulated"].world, engine.platform.amplifier

    def fails():
        raise DeviceError("no answer")

    with monkeypatch.context() as broken:
        broken.setattr(amplifier, "disable", fails)
        jobs = [acquire(engine, tmp_path / f"{k}.h5") for k in range(3)]
        assert world.shots == 0
        assert {job.state for job in jobs} == {JobState.FAILED}
        assert isinstance(jobs[2].error, InterlockError)
        assert "no answer" in engine.status().interlock
    assert acquire(engine, tmp_path / "b.h5").state is JobState.DONE
    assert engine.status().interlock is None


def test_unconfirmed_outputs_are_told_after_one_attempt_and_tried_until_they_are_confirmed(
    engine_with, tmp_path, monkeypatch
):
    engine, told = engine_with(), []
    world, switch = engine.platform.backends["simulated"].world, engine.platform.switch
    move = switch.to_transmit

    def fails():
        if world.shots:
            told.append(job[0].ended.is_set())
            raise DeviceError("no answer")
        move()

    plan = plan_series(engine, AcquisitionRequest(**SHORT_JEWEL))
    job = []
    with monkeypatch.context() as broken:
        broken.setattr(switch, "to_transmit", fails)
        job.append(engine.submit(series_work(engine, plan, OwnFile(tmp_path / "a.h5", tmp_path))))
        assert job[0].ended.wait(timeout=60)
        assert isinstance(job[0].error, OutputsUnconfirmed)
        while len(told) < 4:
            assert "no answer" in engine.status().interlock
            time.sleep(0.01)
    while engine.status().interlock is not None:
        time.sleep(0.01)
    assert told[:4] == [False, True, True, True]
    assert_everything_off(engine)


def test_the_amplifier_is_off_before_the_receiver_is_connected(engine_with, tmp_path, monkeypatch):
    engine, seen = engine_with(), []
    platform, disable = engine.platform, engine.platform.amplifier.disable

    def watched():
        seen.append((platform.card.state(), platform.amplifier.status().enabled, platform.switch.position()))
        disable()

    monkeypatch.setattr(platform.amplifier, "disable", watched)
    acquire(engine, tmp_path / "a.h5")
    assert [position for _, enabled, position in seen if enabled] == [SwitchPosition.TRANSMIT]


def test_the_first_real_time_shot_of_a_process_is_good(engine_with, tmp_path):
    engine = engine_with("backends.simulated.clock.mode='realtime'")
    job = acquire(engine, tmp_path / "a.h5", sequence={"rx_s": 0.3}, window=None)
    assert job.state is JobState.DONE, job.error
    recording = open_recording(tmp_path / "a.h5")
    assert recording.frame_info[0].verdict == "good"
    assert job.platform_clock == recording.provenance.clock == "real"


def test_the_record_of_a_running_job_says_where_its_shots_are(engine_with, tmp_path):
    engine = engine_with(jobs=tmp_path)
    request = AcquisitionRequest(**SHORT_JEWEL, shots=300)
    job = engine.submit(series_work(engine, plan_series(engine, request), OwnFile(tmp_path / "a.h5", tmp_path)))
    while job.progress().done < 2:
        time.sleep(0.02)
    record = json.loads(job_texts(tmp_path)[job.identifier])
    job.request_cancel()
    assert job.ended.wait(timeout=60)
    assert (record["state"], record["clock"]) == ("running", "simulated")
    assert record["times"]["started"]
    assert record["result"]["recording"] == "a"
    assert record["done"] == record["result"]["shots"]


def test_three_refused_shots_in_a_row_end_the_series(engine_with, tmp_path):
    engine = engine_with("backends.simulated.faults.corrupted=[1, 2, 3, 4, 5]")
    job = acquire(engine, tmp_path / "a.h5", shots=5)
    assert job.state is JobState.FAILED
    assert "3 shots in a row" in str(job.error)
    assert open_recording(tmp_path / "a.h5").frames == 3


def test_a_field_above_the_limit_is_rejected_before_anything_moves(engine_with):
    engine = engine_with("limits.max_field_t=4e-4")
    with pytest.raises(SequenceRejected, match="field"):
        plan_series(engine, AcquisitionRequest(resonator="jewel"))
    assert engine.platform.backends["simulated"].world.shots == 0


def test_an_existing_target_is_not_overwritten(engine_with, tmp_path):
    (tmp_path / "a.h5").write_text("precious")
    job = acquire(engine_with(), tmp_path / "a.h5")
    assert job.state is JobState.FAILED
    assert (tmp_path / "a.h5").read_text() == "precious"


def test_outputs_off_from_another_thread_ends_the_shot_and_cancels_the_queue(engine_with, tmp_path):
    engine = engine_with("backends.simulated.clock.mode='realtime'")
    request = AcquisitionRequest(resonator="thread", shots=2)
    jobs = [
        engine.submit(series_work(engine, plan_series(engine, request), OwnFile(tmp_path / f"{n}.h5", tmp_path)))
        for n in "ab"
    ]
    while jobs[0].state is JobState.QUEUED:
        time.sleep(0.01)
    time.sleep(0.3)
    engine.outputs_off()
    assert not engine.platform.amplifier.status().enabled
    assert all(job.ended.wait(timeout=30) for job in jobs)
    assert {job.state for job in jobs} == {JobState.CANCELLED}
    assert_everything_off(engine)


def test_the_same_seed_gives_the_same_volts(engine_with, tmp_path):
    for name in "ab":
        acquire(engine_with("backends.simulated.seed=7"), tmp_path / f"{name}.h5", shots=2)
    first, second = (open_recording(tmp_path / f"{n}.h5") for n in "ab")
    np.testing.assert_array_equal(first.frame_volts(1), second.frame_volts(1))


def test_a_shot_that_is_refused_at_its_beginning_does_not_cost_the_one_before(engine_with, tmp_path, monkeypatch):
    engine = engine_with()
    card, read = engine.platform.card, engine.platform.card.read
    begun = []

    def refuse_the_second(most):
        chunk = read(most)
        begun.extend([chunk.first_sample] if chunk.first_sample == 0 else [])
        if len(begun) == 2:
            raise ShotRefused("bytes are missing")
        return chunk

    monkeypatch.setattr(card, "read", refuse_the_second)
    job = acquire(engine, tmp_path / "a.h5", shots=2)
    assert job.state is JobState.DONE, job.error
    assert [i.verdict for i in open_recording(tmp_path / "a.h5").frame_info] == ["good", "refused"]


def test_who_stops_everything_once_the_card_is_armed_is_not_followed_by_an_enabled_amplifier(
    engine_with, tmp_path, monkeypatch
):
    engine = engine_with()
    platform, enabled = engine.platform, []
    arm, enable = platform.card.arm, platform.amplifier.enable

    def armed():
        arm()
        engine.outputs_off()

    monkeypatch.setattr(platform.card, "arm", armed)
    monkeypatch.setattr(platform.amplifier, "enable", lambda: (enabled.append(1), enable()))
    job = acquire(engine, tmp_path / "a.h5", shots=1)
    assert (job.state, enabled) == (JobState.CANCELLED, [])
