"""What is shown of a job that is waited for, and Ctrl-C meanwhile."""

import pytest

from platform_daemon.client import JobCancelled, display
from platform_daemon.client.sync.jobs import Acquisition
from platform_daemon.core.jobs.kinds import job_type
from platform_daemon.core.schemas.base import EXAMPLES
from tests.kit.acquisitions import SHORT

VIEW = job_type("acquisition").model_validate_json((EXAMPLES / "acquisition_job.json").read_text())


def at(share):
    return VIEW.model_copy(update={"progress": VIEW.progress.model_copy(update={"fraction": share})})


def test_the_bar_never_falls(capsys):
    bar = display.TerminalBar("a job")
    shares = []
    for share in (0.2, 0.6, 0.4, 0.7):
        bar.at(at(share))
        shares.append(bar._bar.tasks[0].completed)  # noqa: SLF001
    bar.close()
    assert shares == [0.2, 0.6, 0.6, 0.7]
    assert capsys.readouterr().out == ""


def test_a_notebook_shows_progress_and_the_last_fit():
    text = display.last_fit(VIEW)
    assert "f_nat_hz" in text
    assert "shots" in display.count_of(VIEW)


@pytest.mark.parametrize(("answer", "stops"), [("y", True), ("", False), (KeyboardInterrupt, False)])
def test_ctrl_c_asks_whether_the_job_is_to_be_stopped(lab, monkeypatch, answer, stops):
    job = lab.measure("jewel", shots=100, pause_s=1.0, **SHORT)

    def refresh(self):
        raise KeyboardInterrupt

    def replied(prompt):
        assert job.id in prompt
        if answer is KeyboardInterrupt:
            raise answer
        return answer

    monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)
    monkeypatch.setattr("builtins.input", replied)
    with monkeypatch.context() as patched:
        patched.setattr(Acquisition, "refresh", refresh)
        with pytest.raises(KeyboardInterrupt):
            job.wait()
    if stops:
        with pytest.raises(JobCancelled):
            job.wait(timeout_s=30)
    else:
        assert not job.refresh().state.final
        job.cancel()


def test_without_a_terminal_the_job_goes_on(capsys, monkeypatch):
    monkeypatch.setattr("sys.stdin.isatty", lambda: False, raising=False)
    assert display.asks_to_stop("a job") is False
    assert "a job goes on" in capsys.readouterr().err
