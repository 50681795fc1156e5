"""What is watched: events, also those of while nobody looked, and the computer."""

import sqlite3
import time
from dataclasses import replace

import pytest

from drivers.errors import DeviceLost
from platform_daemon.core.schemas.events import DeviceEvent, InterlockEvent
from platform_daemon.core.state.errors import StorageError
from platform_daemon.core.state.event_journal import EventJournal
from platform_daemon.features.alarms import watch as module
from platform_daemon.features.alarms.board import AlarmBoard
from platform_daemon.features.alarms.watch import Watch, Watched
from platform_daemon.features.schedules.schema import Schedule, ScheduleRequest


@pytest.fixture
def watching(tmp_path, monkeypatch):
    """Begins a watch on a folder; all are ended."""
    monkeypatch.setattr(module, "_EVENTS_EVERY_S", 0.02)
    monkeypatch.setattr(module, "_COMPUTER_EVERY_S", 0.02)
    watched = Watched(tmp_path, tmp_path / "events.db", tmp_path / "alarms.seen", disk_b=0.0, memory_b=0.0)
    begun = []

    def begin(hardware=lambda: None, schedules=None, **changes):
        board = AlarmBoard(tmp_path / "state.sqlite", lambda event: None)
        begun.append(Watch(replace(watched, **changes), board, hardware, schedules=schedules))
        return board, begun[-1]

    yield begin
    for each in begun:
        each.close()


def wait_for(board, *names):
    until = time.monotonic() + 10
    while set(board.standing()) != set(names):
        assert time.monotonic() < until, board.all()
        time.sleep(0.01)


def wait_until_it_looks(folder):
    until = time.monotonic() + 10
    while not ((seen := folder / "alarms.seen").exists() and seen.read_text().strip().isdigit()):
        assert time.monotonic() < until
        time.sleep(0.01)


def test_what_happens_while_nobody_looks_is_noticed_afterwards_and_only_once(tmp_path, watching):
    journal = EventJournal(tmp_path / "events.db")
    board, watch = watching()
    wait_until_it_looks(tmp_path)
    journal.tell(InterlockEvent(why="the door"))
    wait_for(board, "interlock")
    watch.close()
    journal.tell(DeviceEvent(device="card", error="gone"))
    time.sleep(0.3)
    board, watch = watching()
    wait_for(board, "interlock", "device:card")
    assert [each.times for each in board.all()] == [1, 1]
    watch.close()
    (tmp_path / "alarms.seen").write_text("nonsense")
    board, _ = watching()
    wait_until_it_looks(tmp_path)
    journal.tell(InterlockEvent(why=None))
    wait_for(board, "device:card")
    journal.close()


@pytest.mark.parametrize(
    ("changes", "name"), [({"disk_b": 1e18}, "disk"), ({"memory_b": 1e18}, "memory"), ({"idle_s": 0.05}, "idle")]
)
def test_a_computer_that_runs_out_of_something_raises_an_alarm(watching, changes, name):
    board, _ = watching(**changes)
    wait_for(board, name)


def test_an_owner_that_does_not_answer_and_a_clock_that_leaps_raise_alarms_that_end(watching, monkeypatch):
    answers = []

    def hardware():
        if not answers:
            raise DeviceLost("nobody is there")

    board, _ = watching(hardware)
    wait_for(board, "hardware")
    answers.append(True)
    wait_for(board)
    wall = time.time
    monkeypatch.setattr(module.time, "time", lambda: wall() - 3600)
    until = time.monotonic() + 10
    while not any(each.name == "clock" and "-3600 s" in each.what for each in board.all()):
        assert time.monotonic() < until
        time.sleep(0.01)
    wait_for(board)


def schedule(name, next_due, active=True, ahead_until=None):
    trigger, work = {"cron": "0 22 * * *"}, {"kind": "self_test"}
    request = ScheduleRequest.model_validate({"name": name, "trigger": trigger, "work": work})
    return Schedule(
        id=name, request=request, created="2026-11-24T00:00:00+00:00", active=active, reason=None, failures=0,
        next_due=next_due, ahead_until=ahead_until,
    )  # fmt: skip


def test_alarms_of_a_schedule_that_was_removed_end(watching):
    there = [schedule("nightly", None), schedule("gone", None)]
    board, _ = watching(schedules=lambda: tuple(there))
    for name in ("schedule:nightly", "schedule:gone", "mount:gone", "disk:other"):
        board.notice(name, "x")
    there.pop()
    wait_for(board, "schedule:nightly", "disk:other")


def test_schedules_that_cannot_be_used_raise_an_alarm_that_says_why(watching):
    why = [StorageError("the ledger is damaged", where="schedules.db", remedy="put back a copy")]

    def schedules():
        if why:
            raise why[0]
        return ()

    board, _ = watching(schedules=schedules)
    wait_for(board, "schedules")
    assert "the ledger is damaged" in board.all()[0].what
    why.clear()
    wait_for(board)


def test_who_is_told_that_nothing_has_begun_is_told_what_is_due_next(watching):
    due = "2028-02-29T00:00:00+00:00"
    there = (
        schedule("leap", due),
        schedule("off", "2027-01-01T00:00:00.5+00:00", active=False),
        schedule("past", None),
    )
    board, _ = watching(schedules=lambda: there, idle_s=0.05)
    wait_for(board, "idle")
    assert f"nothing is due until {due} (leap)" in board.all()[0].what


def test_a_ledger_that_is_ahead_of_the_clock_is_an_alarm_that_stands_until_somebody_resumes(watching):
    there = [schedule("nightly", None, ahead_until="2031-01-01T00:00:00+00:00"), schedule("hourly", None)]
    board, _ = watching(schedules=lambda: tuple(there))
    wait_for(board, "ledger-ahead")
    said = board.all()[0].what
    assert "nightly until 2031-01-01" in said
    assert "hourly" not in said
    there[0] = schedule("nightly", None)
    wait_for(board)


def test_a_schedule_that_another_version_has_left_is_an_alarm_until_it_is_removed(watching):
    there = [schedule("nightly", None)]
    there.append(there[0].model_copy(update={"id": "left", "request": None, "reason": "cannot be read"}))
    board, _ = watching(schedules=lambda: tuple(there))
    wait_for(board, "schedules-unreadable")
    assert "nothing starts of left: cannot be read" in board.all()[0].what
    there.pop()
    wait_for(board)


def test_what_another_version_has_told_does_not_end_the_watch(tmp_path, watching):
    journal = EventJournal(tmp_path / "events.db")
    board, _ = watching()
    wait_until_it_looks(tmp_path)
    with sqlite3.connect(tmp_path / "events.db") as sql:
        sql.execute("INSERT INTO events (at, kind, what) VALUES ('', 'dream', '{}')")
    sql.close()
    journal.tell(InterlockEvent(why="the door"))
    wait_for(board, "interlock")
    journal.close()
