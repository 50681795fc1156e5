"""What a waiting user sees: a bar that never falls, the time left, and questions in their place."""

import io
import os
import subprocess
import sys
import threading

import pytest
from rich.console import Console
from rich.progress import Progress

from platform_daemon.core.command_line.progress import ProgressDisplay, compile_fit
from platform_daemon.core.command_line.shot_lines import ShotLines
from platform_daemon.core.jobs.jobs import Job
from platform_daemon.core.schemas.acquisitions import ShotReport
from platform_daemon.core.schemas.fits import ParameterEstimate, unfitted
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.estimation import compilation


class Clock:
    """Put forward by hand."""

    now = 0.0

    def __call__(self):
        return self.now


@pytest.fixture
def seen():
    clock = Clock()
    bar = Progress(console=Console(file=io.StringIO()), get_time=clock)
    display = ProgressDisplay(bar)
    return display, bar.tasks[0], clock


def test_it_never_falls_within_a_piece_of_work_and_begins_anew_with_the_next(seen):
    display, task, _ = seen
    display.begin("first", 10.0, "shots")
    for done, shown in ((2.0, 2.0), (1.0, 2.0), (5.0, 5.0)):
        display.at(done)
        assert task.completed == shown
    assert task.description == "first"
    display.tell("checks", 0.0)
    assert (task.completed, task.total, task.fields["unit"], task.description) == (0.0, 100.0, "%", "checks")
    display.tell("refits", 0.3)
    display.tell("refits again", 0.25)
    assert (task.completed, task.description) == (30.0, "refits again")


def test_the_time_left_follows_from_the_mean_pace(seen):
    display, _, clock = seen
    clock.now = 100.0
    display.begin("fit", 4.0, "files")
    assert display.time_left == ""
    clock.now = 103.0
    display.at(1.0)
    assert display.time_left == "9 s left"
    clock.now = 106.0
    display.at(4.0)
    assert display.time_left == "0 s left"


def test_a_job_is_watched_to_its_end_and_its_question_is_put_to_the_operator(seen, monkeypatch):
    display, task, _ = seen
    job, asked = Job("calibration", {}, {}, 2.0, "points"), []

    def work(job):
        job.ask("turn the coil")
        assert job.proceed.wait(10)
        job.answered()
        job.at(2.0, "done")

    monkeypatch.setattr(display, "ask", asked.append)
    threading.Thread(target=job.run, args=(work,)).start()
    display.watch(job)
    assert job.state is JobState.DONE
    assert asked == ["turn the coil, then press Enter"]
    assert (task.total, task.fields["unit"]) == (2.0, "points")


@pytest.mark.parametrize("ends", [KeyboardInterrupt, OSError])
def test_what_ends_the_watch_cancels_the_job_before_a_terminal_that_is_halted_can_hold_that_up(seen, monkeypatch, ends):
    display, _, _ = seen
    job = Job("calibration", {}, {}, 2.0, "points")

    def refuse(*args):
        raise ends

    monkeypatch.setattr(display, "at", refuse)
    with pytest.raises(ends):
        display.watch(job)
    assert job.cancel_requested.is_set()


def shot(number, **keys):
    known = {"blank": False, "verdict": "good", "reason": None, "fit": None}
    return ShotReport(shot=number, frame=number - 1, time_stamp=None, temperature_c=None, **known | keys)


def fit(f_nat_hz):
    values = {
        "f_nat_hz": ParameterEstimate(value=f_nat_hz, std=0.0007),
        "phi_max_rad": ParameterEstimate(value=0.95, std=1e-5),
    }
    good = {"verdict": "good", "reason": None, "parameters": values, "chi2_per_dof": 1.004}
    return unfitted(0, "").model_copy(update=good)


def test_each_shot_of_a_series_is_a_line_in_order_once_its_fit_is_there(seen):
    display, task, _ = seen
    job = Job("acquisition", AcquisitionRequest(resonator="jewel"), {}, 5.0, "shots")
    lines = ShotLines(job)
    job.shots.stored(shot(1, blank=True))
    job.shots.stored(shot(2))
    job.shots.stored(shot(3, verdict="refused", reason="clipped"))
    assert list(lines.new()) == ["shot 1/5: blank"]
    job.shots.fitted(2, fit(213.5))
    assert list(lines.new()) == [
        "shot 2/5: f_nat 213.50000(70) Hz, φ_max 54.43099(57) °, χ²/dof 1.004", "shot 3/5: refused: clipped",
    ]  # fmt: skip
    job.shots.stored(shot(4))
    job.shots.fitted(4, fit(213.6))
    job.shots.stored(shot(5))
    assert len(list(lines.new())) == 1
    assert lines.curve() == "f_nat ▁█ 0.1 Hz"
    job.ended.set()
    assert list(lines.new()) == ["shot 5/5: not fitted"]
    display.watch(job)
    assert task.fields["curve"] == "f_nat ▁█ 0.1 Hz"


def test_a_first_fit_says_that_it_compiles_and_how_long_that_took(monkeypatch, capsys):
    monkeypatch.setattr(compilation, "is_compiled", lambda: False)
    monkeypatch.setattr(compilation, "warm_up", lambda: 31.4)
    compile_fit()
    out, err = capsys.readouterr()
    assert (out, err.splitlines()) == ("", [compilation.COMPILING, "compiled in 31 s"])


def test_a_fit_whose_kernels_are_in_the_cache_says_nothing_of_compiling(monkeypatch, capsys):
    monkeypatch.setattr(compilation, "is_compiled", lambda: True)
    monkeypatch.setattr(compilation, "warm_up", lambda: pytest.fail("compiled"))
    compile_fit()
    assert capsys.readouterr() == ("", "")


def test_an_empty_cache_is_known_as_such_without_compiling(tmp_path):
    code = "from platform_daemon.estimation.compilation import is_compiled; assert not is_compiled()"
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    subprocess.run([sys.executable, "-c", code], check=True, timeout=120, env=environment)


def test_after_the_warm_up_all_is_compiled():
    compilation.warm_up()
    assert compilation.is_compiled()
