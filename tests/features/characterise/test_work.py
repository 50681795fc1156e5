"""Characterise on the simulated platform: shots, tables, progress; cancelled and paused while it fits."""

import time

import numpy as np
import pytest

from drivers.errors import InputError
from platform_daemon.core.recordings.fit_joining import NOT_FITTED
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recorded_fits import read_fit
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.features.characterise.schema import CharacterisationReport, CharacteriseRequest
from platform_daemon.features.procedures.bench import ProcedureBench, ReportFiles
from platform_daemon.features.procedures.conductor import PauseTooLong, ProcedureFiles
from platform_daemon.features.procedures.planned import plan_procedure
from platform_daemon.features.procedures.schema import ProcedureLog

SHOTS = 4


def begun(engine, folder, longest_pause_s=60.0, held=None, tune=False, ramp=None, **keys):
    """The job of a short one."""
    asked = {"resonator": "jewel", "shots": SHOTS, "blank_shots": 1, "sequence": {"rx_s": 0.6, "pause_s": 5.0}, **keys}
    request = CharacteriseRequest.model_validate(
        {"kind": "characterise", "acquisition": asked, "held_in_n50": held or {}, "longest_pause_s": longest_pause_s}
        | {"tune": tune, "ramp": ramp}
    )
    files = ProcedureFiles(folder, folder, folder / "c.h5", folder / "log.json")
    reports = ReportFiles(report=folder / "c.json", html=folder / "c.html")
    return engine.submit(plan_procedure(ProcedureBench(engine=engine, files=files, reports=reports), request))


def fitting(job):
    """Wait until the fits over both windows have begun."""
    deadline = time.monotonic() + 120
    while "fits" not in job.phase and not job.ended.is_set():
        assert time.monotonic() < deadline
        time.sleep(0.001)


def test_the_shots_become_one_recording_tables_and_a_page(engine_with, tmp_path):
    job = begun(engine_with(), tmp_path)
    seen = []
    while not job.ended.wait(timeout=0.005):
        seen.append((job.progress().fraction, job.phase))
    assert job.state is JobState.DONE, job.error
    recording = open_recording(tmp_path / "c.h5")
    assert recording.frames == SHOTS + 1
    report = CharacterisationReport.model_validate_json((tmp_path / "c.json").read_text())
    assert report == job.result.outcome.report
    assert [frame.frame for frame in report.d30_fits.frames] == list(range(1, SHOTS + 1))
    short = read_fit(recording, "n50_characterise")
    assert short.verdict == ("refused",) + ("good",) * SHOTS
    assert short.reason[0] == NOT_FITTED
    for fit in report.n50_fits.frames:
        assert dict(zip(short.parameters, short.values[fit.frame], strict=True)) == fit.values
        rows = [short.parameters.index(name) for name in fit.covariance.parameters]
        assert np.array_equal(short.covariance[fit.frame][np.ix_(rows, rows)], fit.covariance.matrix)
    assert (tmp_path / "c.html").read_text().startswith("<!doctype html>")
    log = ProcedureLog.model_validate_json((tmp_path / "log.json").read_text())
    assert (log.result, log.request.kind) == (job.result, "characterise")
    shares = [share for share, _ in seen]
    assert shares == sorted(shares)
    assert job.progress().fraction == 1.0
    before = [share for share, phase in seen if phase.startswith("step")]
    assert max(before) < 1.0  # the fits are part of what is left


@pytest.mark.long
def test_after_tune_and_a_ramp_without_a_threshold_shots_stay_below_its_highest_field(engine_with, tmp_path):
    ramp = {"start_t": 2.4e-4, "max_t": 2.5e-4}
    job = begun(engine_with(), tmp_path, tune=True, shots=2, blank_shots=0, ramp=ramp)
    assert job.ended.wait(timeout=120)
    assert job.state is JobState.DONE, job.error
    outcome = job.result.outcome
    assert (outcome.ramp.operating_field_t, outcome.ramp.ended_by) == (None, "requested_limit")
    tuned = outcome.tune.shots
    excited = [info.excitation for info in open_recording(tmp_path / "c.h5").frame_info][tuned:]
    assert [e.field_t for e in excited] == pytest.approx([2.4e-4] + [0.0] * 3 + [2.4e-4, 2.5e-4] + [2.5e-4] * 2)
    assert {e.requested_hz for e in excited} == {outcome.tune.sequence.f_tx_hz}
    assert outcome.tune.sequence.f_tx_hz == pytest.approx(outcome.tune.f_nat_hz.value, rel=0.02)
    assert [frame.frame for frame in outcome.report.d30_fits.frames] == [tuned + 6, tuned + 7]
    assert outcome.report.excitation.field_t == pytest.approx(2.5e-4)
    (said,) = [w for w in job.warnings if "no threshold was found" in w]
    assert "the highest field of the ramp: the preset's field, 490 uT, lies above it" in said
    assert outcome.report.notes[0] == said
    assert said in (tmp_path / "c.html").read_text().replace("&#39;", "'")


@pytest.mark.long
def test_a_ramp_without_a_threshold_leaves_the_field_of_the_preset_and_says_so(engine_with, tmp_path):
    job = begun(
        engine_with("limits.max_field_t=5e-4"), tmp_path, shots=1, blank_shots=0, ramp={"start_t": 5e-4},
        sequence={"rx_s": 0.6, "pause_s": 5.0},
    )  # fmt: skip
    assert job.ended.wait(timeout=120)
    assert job.state is JobState.DONE, job.error
    outcome = job.result.outcome
    assert (outcome.ramp.ended_by, outcome.ramp.max_field_t) == ("platform_limit", None)
    assert outcome.report.excitation.field_t == pytest.approx(490e-6)
    assert "the shots are made in the preset's field, 490 uT" in outcome.report.notes[0]
    assert not (tmp_path / "c.toml").exists()


@pytest.mark.long
def test_cancelled_while_it_fits_the_recording_is_whole_and_there_are_no_tables(engine_with, tmp_path):
    job = begun(engine_with(), tmp_path)
    fitting(job)
    job.request_cancel()
    assert job.ended.wait(timeout=60)
    assert job.state is JobState.CANCELLED
    assert open_recording(tmp_path / "c.h5").frames == SHOTS + 1
    assert not (tmp_path / "c.json").exists()
    assert job.result.outcome is None


@pytest.mark.long
def test_a_pause_rests_between_two_fits_and_one_too_long_ends_it(engine_with, tmp_path):
    engine = engine_with()
    job = begun(engine, tmp_path, longest_pause_s=0.3)
    fitting(job)
    job.pause_requested.set()
    assert job.ended.wait(timeout=60)
    assert isinstance(job.error, PauseTooLong)
    assert open_recording(tmp_path / "c.h5").provenance.incomplete is None


@pytest.mark.long
def test_a_resonator_that_never_rings_is_said_in_words(engine_with, tmp_path):
    job = begun(engine_with(), tmp_path, sequence={"rx_s": 0.6, "axis": "z"}, shots=2)
    assert job.ended.wait(timeout=120)
    report = job.result.outcome.report
    assert (report.n50.good, report.d30.good, report.d30.shots) == (0, 0, 2)
    assert any("no good shot" in note for note in report.notes)
    assert "every shot was refused in both windows" in job.warnings


def test_what_cannot_be_is_refused_before_anything_moves(engine_with, tmp_path):
    engine = engine_with()
    for keys in ({"sequence": {"field_t": 5e-3}}, {"held": {"m_r_am2": 0.01}}, {"resonator": "spring"}):
        with pytest.raises(InputError):
            begun(engine, tmp_path, **keys)
    assert list(tmp_path.iterdir()) == []
