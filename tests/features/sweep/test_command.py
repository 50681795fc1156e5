"""`platform-daemon sweep`: the plan, the steps, Ctrl-C, kill -9, and what is refused in one line."""

import signal
import subprocess
import threading

import pytest

from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recovery import recover
from platform_daemon.features.procedures import command
from platform_daemon.features.procedures.schema import ProcedureLog, ProcedureSummary
from tests.kit.command_line import COMMAND, assert_one_line_error, here, wait_for

QUICK = ("--resonator", "jewel", "--rx-s", "0.3", "--window", "n50")


def steps_of(log):
    return ProcedureLog.model_validate_json(log.read_text()).result.steps if log.exists() else ()


@pytest.fixture(autouse=True)
def kernels_are_there(monkeypatch):
    """Other tests of this process may have compiled them; the first fit does so otherwise."""
    monkeypatch.setattr(command, "prepare_fit", lambda: None)


def test_a_sweep_writes_one_recording_a_log_and_a_table_of_steps(tmp_path):
    options = ("--over", "field_ut=200:400:100", "--stop-when", "phi_max_deg>25", "--json", tmp_path / "s.json")
    done = here("sweep", *QUICK, *options, "--output", tmp_path / "s.h5")
    assert done.returncode == 0, done.stderr
    assert "2 of 3 steps" in done.stdout
    assert "phi_max_deg > 25 in step 2" in done.stdout
    assert open_recording(tmp_path / "s.h5").frames == 2
    assert (tmp_path / "s.json").read_text() == (tmp_path / "s.h5.log.json").read_text()
    shown = here("info", tmp_path / "s.h5")
    assert "stopped after 2 of 3 steps" in " ".join(shown.stdout.split())
    assert "2: field_ut =" in shown.stdout
    again = here("sweep", *QUICK, *options, "--output", tmp_path / "s.h5", "--force")
    assert again.returncode == 0, again.stderr


def test_the_dry_run_shows_every_step_and_writes_nothing_but_its_json(tmp_path):
    options = ("--over", "field_ut=200:300:50", "--over", "axis=x,y", "--dry-run", "--json", tmp_path / "plan.json")
    done = here("sweep", *QUICK, *options, "--output", tmp_path / "s.h5")
    assert done.returncode == 0, done.stderr
    assert "6 steps, 6 shots," in done.stdout
    plan = ProcedureSummary.model_validate_json((tmp_path / "plan.json").read_text())
    assert [v.value for v in plan.steps[3].values] == [250, "y"]
    assert [path.name for path in tmp_path.iterdir()] == ["plan.json"]


@pytest.mark.long
def test_ctrl_c_ends_it_in_order_and_what_was_measured_is_put_together(tmp_path):
    def interrupt():
        wait_for(lambda: len(steps_of(tmp_path / "s.h5.log.json")) >= 2)
        signal.raise_signal(signal.SIGINT)

    striking = threading.Thread(target=interrupt)
    striking.start()
    done = here("sweep", *QUICK, "--over", "pause_s=0:0.9:0.001", "--output", tmp_path / "s.h5")
    striking.join()
    assert done.returncode == 130
    assert "cancelled" in done.stdout
    log = steps_of(tmp_path / "s.h5.log.json")
    recording = open_recording(tmp_path / "s.h5")
    assert recording.frames == sum(len(step.frames) for step in log) >= 2
    assert recording.provenance.incomplete.endswith("of 901 steps: cancelled")


@pytest.mark.long
def test_kill_minus_nine_loses_no_shot_of_a_step_in_the_log_and_the_log_can_be_read(tmp_path):
    options = ("--over", "pause_s=0:0.9:0.001", "--output", tmp_path / "s.h5")
    with subprocess.Popen([COMMAND, "sweep", *QUICK, *options], stderr=subprocess.DEVNULL) as process:
        wait_for(lambda: len(steps_of(tmp_path / "s.h5.log.json")) >= 2)
        process.kill()
    log = ProcedureLog.model_validate_json((tmp_path / "s.h5.log.json").read_text())
    assert log.result.stopped is None
    assert recover(tmp_path) == [tmp_path / "s.h5"]
    recording = open_recording(tmp_path / "s.h5")
    assert recording.frames >= sum(len(step.frames) for step in log.result.steps) >= 2
    for step in log.result.steps:
        labels = [recording.frame_info[k].step.label for k in step.frames]
        assert [(label.number, label.values["pause_s"]) for label in labels] == [(step.step, step.values[0].value)]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--over", "field=1:2:1"), ("no key of an acquisition", "sequence.field_t")),
        (("--over", "field_ut=1:2:0"), ("over.0", "step of 0")),
        (("--over", "field_ut=1:2"), ("--over", "KEY=FROM:TO:STEP")),
        (("--over", "field_ut=a:b:c"), ("--over", "KEY=FROM:TO:STEP")),
        (("--over", "field_ut=200:2000:900"), ("step 2 (field_ut = 1100)", "max_field_t")),
        (("--over", "field_ut=200,300", "--stop-when", "phi_max_deg 40"), ("--stop-when", "RESULT OP VALUE")),
        (("--over", "field_ut=200,300", "--stop-when", "phi > 40"), ("stop_when", "phi_max_rad")),
        ((), ("--over",)),
    ],
)
def test_what_cannot_be_swept_is_told_in_one_line_and_nothing_is_written(tmp_path, options, words):
    done = here("sweep", *QUICK, *options, "--output", tmp_path / "s.h5")
    assert_one_line_error(done, 2, *words)
    assert list(tmp_path.iterdir()) == []


def test_a_sweep_of_which_no_step_can_be_used_ends_with_code_3_and_one_that_failed_with_1(tmp_path):
    done = here("sweep", *QUICK, "--over", "field_ut=0.001,0.002", "--output", tmp_path / "a.h5")
    assert done.returncode == 3, done
    assert "no step can be used" in done.stderr
    fault = ("--set", "backends.simulated.faults.amplifier_trip=[2]")
    done = here("sweep", *QUICK, "--over", "field_ut=200,300", "--output", tmp_path / "b.h5", *fault)
    assert_one_line_error(done, 1, "step 2 (field_ut = 300)", "tripped")
    assert open_recording(tmp_path / "b.h5").frames == 1
