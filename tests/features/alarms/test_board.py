"""The board of alarms: each stands once, is over, is known of, and outlives the process."""

import contextlib
import json
import sys
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

from drivers.errors import ConfigError, DeviceStateError, InputError
from platform_daemon.core.schemas.events import (
    DeviceEvent,
    FitEvent,
    InterlockEvent,
    JobEvent,
    ScheduleEvent,
    ShotEvent,
)
from platform_daemon.core.schemas.jobs import JobState, Progress
from platform_daemon.core.state.database import Database
from platform_daemon.core.state.errors import StorageError
from platform_daemon.features.alarms import caller as caller_module
from platform_daemon.features.alarms.board import MOST_CLEARED, AlarmBoard, UnknownAlarm
from platform_daemon.features.alarms.caller import Caller
from platform_daemon.features.alarms.rules import Rules
from tests.kit.command_line import wait_for
from tests.kit.no_room import no_room


@pytest.fixture
def told():
    return []


@pytest.fixture
def board(tmp_path, told):
    return AlarmBoard(tmp_path / "state.sqlite", told.append, told.append)


def test_an_alarm_stands_once_however_often_it_is_noticed_and_is_told_once(board, told):
    for _ in range(3):
        board.notice("disk", "full")
    assert [(each.name, each.times) for each in board.all()] == [("disk", 3)]
    assert len(told) == 2  # the event and the call
    board.clear("disk")
    board.clear("disk")
    assert [each.state for each in told if hasattr(each, "state")] == ["raised", "cleared"]
    assert board.standing() == ()
    board.notice("disk", "full again")
    assert board.all()[0].times == 1


def test_alarms_outlive_the_process_and_a_broken_file_costs_only_them(board, tmp_path):
    board.notice("disk", "full")
    board.acknowledge("disk", " me ")
    again = AlarmBoard(tmp_path / "state.sqlite", lambda event: None)
    assert [(each.name, each.acknowledged_by) for each in again.all()] == [("disk", "me")]
    (tmp_path / "state.sqlite").write_text("{")
    assert AlarmBoard(tmp_path / "state.sqlite", lambda event: None).all() == ()


def test_what_the_disk_does_not_take_is_not_acknowledged(board, monkeypatch):
    board.notice("disk", "full")
    monkeypatch.setattr(Database, "transaction", no_room)
    with pytest.raises(StorageError, match="the disk is full"):
        board.acknowledge("disk", "me")
    assert board.all()[0].acknowledged_by is None


def test_only_an_alarm_that_stands_can_be_acknowledged_and_by_a_name(board):
    with pytest.raises(UnknownAlarm, match="no alarm is called 'disk'"):
        board.acknowledge("disk", "me")
    board.notice("disk", "full")
    with pytest.raises(InputError, match="no person is named"):
        board.acknowledge("disk", "  ")
    board.clear("disk")
    with pytest.raises(DeviceStateError, match="is over"):
        board.acknowledge("disk", "me")


def test_of_those_that_are_over_a_hundred_are_kept(board):
    for k in range(MOST_CLEARED + 20):
        board.notice(str(k), "x")
        board.clear(str(k))
    assert len(board.all()) == MOST_CLEARED


def shot(verdict, *, blank=False):
    return ShotEvent(
        job="a", shot=1, of=9, recording="a", frame=0, blank=blank, verdict=verdict, reason=None
    )  # fmt: skip


def fit(verdict, job="acquisition-1"):
    return FitEvent(
        job=job, shot=1, verdict=verdict, reason="no oscillation", f_nat_hz=None, f_nat_std_hz=None, phi_max_rad=None,
        nrmse=None, chi2_per_dof=None, whiteness=None, warnings=(), seconds=0.01,
    )  # fmt: skip


def job(state, error=None, done=0.0, within=None):
    progress = Progress(done=done, total=4.0, unit="shots", phase="", fraction=done / 4, time_left_s=None)
    return JobEvent(
        job="acquisition-1", job_kind="acquisition", state=state, progress=progress, within=within, recording=None,
        error=error,
    )  # fmt: skip


def row(state, **more):
    due = "2026-11-24T02:00:00+00:00"
    return ScheduleEvent(schedule="nightly", due=due, state=state, reason="busy", job=None, **more)


@pytest.mark.parametrize(
    ("raising", "name", "text", "clearing"),
    [
        ([shot("refused")] * 3, "shots", "3 of the last 3 shots were refused", [shot("good")] * 10),
        ([fit("refused")] * 3, "fits", "3 of the last 3 on-line fits were refused", [fit("good")] * 10),
        ([InterlockEvent(why="the door")], "interlock", "the door", [InterlockEvent(why=None)]),
        ([DeviceEvent(device="card", error="gone")], "device:card", "gone", [DeviceEvent(device="card", error=None)]),
        ([job(JobState.FAILED, "x")], "failed:acquisition", "died at its launch: x", [job(JobState.DONE)]),
        ([job(JobState.FAILED, "x", 2.0)], "failed:acquisition", "after 50%", [job(JobState.DONE)]),
        ([row("missed")], "schedule:nightly", "was missed: busy", [row("run")]),
        ([row("failed")], "schedule:nightly", "failed: busy", [row("late")]),
        ([row("due"), row("run")], "mount:nightly", "busy", [row("started")]),
    ],
)
def test_what_raises_an_alarm_and_what_ends_it(board, raising, name, text, clearing):
    rules = Rules(board)
    for each in raising:
        rules.see(each)
    assert board.standing() == (name,)
    assert text in board.all()[0].what
    for each in clearing:
        rules.see(each)
    assert board.standing() == ()


def test_a_start_by_hand_ends_no_alarm_of_a_schedule_that_is_switched_off(board):
    rules = Rules(board)
    rules.see(row("failed", active=False))
    assert board.standing() == ()
    rules.see(row("failed"))
    rules.see(row("run", active=False))
    assert board.standing() == ("schedule:nightly",)
    rules.see(row("run"))
    assert board.standing() == ()


def test_blank_shots_single_refusals_and_steps_of_procedures_raise_none(board):
    rules = Rules(board)
    for each in [shot("refused", blank=True)] * 5 + [shot("refused"), shot("good")] * 1:
        rules.see(each)
    rules.see(job(JobState.FAILED, "x", within="procedure-1"))
    rules.see(row("skipped"))
    rules.see(job(JobState.RUNNING, within="procedure-1"))
    for each in [fit("refused")] * 5:  # what a procedure tries out
        rules.see(each)
    assert board.standing() == ()


def test_a_storm_does_not_wait_for_the_disk_each_time(board, monkeypatch):
    written, transaction = [], Database.transaction
    monkeypatch.setattr(Database, "transaction", lambda file: (written.append(file), transaction(file))[1])
    for k in range(2000):
        board.notice("schedule:nightly", f"start {k} was missed")
    assert board.all()[0].times == 2000
    assert len(written) < 20


def test_a_command_gets_the_alarm_and_a_bad_one_is_refused(tmp_path):
    target = tmp_path / "called.json"
    code = f"import sys; open({str(target)!r}, 'w').write(sys.stdin.read())"
    board = AlarmBoard(tmp_path / "state.sqlite", lambda event: None, Caller(f'{sys.executable} -c "{code}"'))
    board.notice("disk", "full")
    until = time.monotonic() + 20
    while not target.exists() or not target.read_text():
        assert time.monotonic() < until
        time.sleep(0.02)
    assert json.loads(target.read_text())["what"] == "full"
    with pytest.raises(ConfigError, match="alarm-command"):
        Caller("say 'this")
    for nothing in ("", "  "):
        with pytest.raises(ConfigError, match="names no command"):
            Caller(nothing)
    with pytest.raises(ConfigError, match="alarm-url"):
        Caller(url="ftp://x")


@contextlib.contextmanager
def answering(answer):
    """A server that answers by `answer(handler, over)`; its URL, and the names of alarms that it was called with."""
    called, over = [], threading.Event()

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self):
            called.append(json.loads(self.rfile.read(int(self.headers["Content-Length"])))["name"])
            with contextlib.suppress(OSError):
                answer(self, over)

        def log_message(self, *arguments):
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/", called
    finally:
        over.set()
        server.shutdown()


def endless(handler, over):
    handler.send_response(200)
    handler.end_headers()
    while not over.is_set():
        handler.wfile.write(b"x" * 65536)


def slow(handler, over):
    handler.wfile.write(b"HTTP/1.1 200 OK\r\n")
    while not over.wait(0.1):
        handler.wfile.write(b"X-Y: z\r\n")


def two_alarms(folder, caller):
    board = AlarmBoard(folder / "state.sqlite", lambda event: None, caller)
    board.notice("disk", "full")
    board.notice("memory", "little")


def test_a_url_is_called_though_the_command_fails_and_its_answer_never_ends(tmp_path):
    with answering(endless) as (url, called):
        two_alarms(tmp_path, Caller(f'{sys.executable} -c "raise SystemExit(3)"', url))
        wait_for(lambda: called == ["disk", "memory"], 20)


def test_an_answer_that_comes_byte_by_byte_holds_up_no_other_call(tmp_path, monkeypatch):
    monkeypatch.setattr(caller_module, "_PATIENCE_S", 0.3)
    with answering(slow) as (url, called):
        two_alarms(tmp_path, Caller(url=url, again_after_s=()))
        wait_for(lambda: called == ["disk", "memory"], 20)


def test_a_url_whose_host_can_be_none_keeps_the_command_from_nothing(tmp_path):
    target = tmp_path / "called"
    code = f"import sys; open({str(target)!r}, 'a').write(sys.stdin.read())"
    two_alarms(tmp_path, Caller(f'{sys.executable} -c "{code}"', "http://hooks..example/", again_after_s=()))
    wait_for(lambda: target.exists() and "memory" in target.read_text(), 20)


def test_who_could_not_be_called_is_called_again_until_the_call_gets_through_and_others_do_not_wait(tmp_path):
    target, counted = tmp_path / "called", tmp_path / "tried"
    code = (
        f"import json, sys; alarm = json.load(sys.stdin)['name']; tried = open('{counted}', 'a'); "
        f"print(alarm, file=tried); tried.close(); many = open('{counted}').read().split().count('disk'); "
        f"sys.exit(1) if alarm == 'disk' and many < 3 else print(alarm, file=open('{target}', 'a'))"
    )
    caller = Caller(f'{sys.executable} -c "{code}"', again_after_s=(0.3, 0.3))
    board = AlarmBoard(tmp_path / "state.sqlite", lambda event: None, caller)
    board.notice("disk", "full")
    board.notice("memory", "little")
    until = time.monotonic() + 30
    while not target.exists() or target.read_text().split() != ["memory", "disk"]:
        assert time.monotonic() < until
        time.sleep(0.02)
    time.sleep(0.5)
    assert counted.read_text().split().count("disk") == 3  # no more once it was delivered
