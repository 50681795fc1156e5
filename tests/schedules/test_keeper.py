"""Schedules whose ledger cannot be opened when the daemon begins, or is taken away while it runs."""

import errno
import json
from pathlib import Path

import pytest

from platform_daemon.schedules import ScheduleKeeper, Schedules, keeper, rest_mark
from platform_daemon.schedules.ledger import Ledger
from platform_daemon.schedules.ledger_file import DamagedLedger
from platform_daemon.schemas import ScheduleRequest
from platform_daemon.store import StorageError
from tests.kit.command_line import wait_for

STOPPED = "everything was stopped"
REQUEST = ScheduleRequest.model_validate_json(
    json.dumps({"name": "n", "trigger": {"every_s": 3600}, "work": {"kind": "self_test"}})
)


class Nobody:
    def planned_s(self, work):
        return None

    def busy(self):
        return False


class Folder:
    """A data folder, of which the disk may refuse."""

    def __init__(self, folder):
        self.path, self.refuses = folder / "schedules.db", False
        self.keepers = []

    def make(self):
        if self.refuses:
            raise StorageError("the disk is full")
        return Schedules(self.path, Nobody())

    def keeper(self):
        self.keepers.append(ScheduleKeeper(self.make, rest_mark(self.path)))
        return self.keepers[-1]

    def end(self):
        for each in self.keepers:
            each.stop_starting()
            each.close()


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(keeper, "_AGAIN_S", 0.02)
    made = Folder(tmp_path)
    first = made.keeper()
    first.open()
    first.get().add(REQUEST)
    made.end()
    yield made
    made.end()


def can_be_asked(kept):
    try:
        kept.get()
    except StorageError:
        return False
    return True


def test_a_disk_that_refuses_is_tried_again_and_a_stop_meanwhile_holds(folder):
    folder.refuses, kept = True, folder.keeper()
    kept.open()
    with pytest.raises(StorageError, match="the disk is full"):
        kept.get()
    assert "the disk is full" in str(kept.pause_all(STOPPED))
    folder.refuses = False
    wait_for(lambda: can_be_asked(kept))
    assert kept.get().list()[0].reason == STOPPED
    kept.get().step()
    assert not rest_mark(folder.path).stands
    folder.end()
    again = folder.keeper()
    again.open()
    assert [(each.active, each.reason) for each in again.get().list()] == [(False, STOPPED)]
    again.get().resume(again.get().list()[0].identifier)
    folder.end()
    last = folder.keeper()
    last.open()
    last.get().step()
    assert [each.active for each in last.get().list()] == [True]


def test_a_stop_while_the_ledger_is_damaged_holds_once_a_copy_is_put_back(folder):
    whole = folder.path.read_bytes()
    folder.path.write_bytes(whole[:3000])
    kept = folder.keeper()
    kept.open()
    assert "cut off after 3000 bytes" in str(kept.pause_all(STOPPED))
    with pytest.raises(DamagedLedger, match="put back a copy"):
        kept.get()
    folder.end()
    folder.path.write_bytes(whole)
    again = folder.keeper()
    again.open()
    assert [each.active for each in again.get().list()] == [False]


def test_a_stop_between_two_tries_is_told_to_what_is_opened_then(folder):
    folder.refuses, kept = True, folder.keeper()
    kept.open()
    kept.rest(STOPPED)
    folder.refuses = False
    wait_for(lambda: can_be_asked(kept))
    assert kept.get().list()[0].reason == STOPPED
    assert kept.pause_all(STOPPED) is None
    assert not rest_mark(folder.path).stands


def test_one_that_is_told_to_end_while_it_opens_them_lets_them_go(folder):
    made = []

    def told_to_end():
        made.append(folder.make())
        kept.stop_starting()
        return made[0]

    kept = ScheduleKeeper(told_to_end, rest_mark(folder.path))
    kept.open()
    kept.close()
    assert not can_be_asked(kept)
    with pytest.raises(StorageError):
        made[0].list()


def test_a_disk_that_does_not_even_answer_is_tried_again(folder, monkeypatch):
    asked, exists = [], Path.exists

    def refused(path):
        if path == folder.path and len(asked) < 2:
            asked.append(path)
            raise OSError(errno.EIO, "Input/output error")
        return exists(path)

    monkeypatch.setattr(Path, "exists", refused)
    kept = folder.keeper()
    kept.open()
    with pytest.raises(StorageError, match="Input/output error"):
        kept.get()
    wait_for(lambda: can_be_asked(kept))


def test_a_ledger_that_is_taken_away_is_told_and_nothing_is_written_into_nowhere(folder):
    kept = folder.keeper()
    kept.open()
    away = folder.path.with_name("elsewhere.db")
    folder.path.rename(away)
    for ask in (kept.get().list, kept.get().step, lambda: kept.get().add(REQUEST)):
        with pytest.raises(StorageError, match="taken away"):
            ask()
    away.rename(folder.path)
    assert len(kept.get().list()) == 1


def test_a_ledger_is_begun_whole_or_not_at_all(tmp_path):
    path = tmp_path / "schedules.db"
    (tmp_path / ".schedules.db.part").write_bytes(b"of one that died here")
    Ledger(path).close()
    assert [each.name for each in tmp_path.iterdir()] == ["schedules.db"]
    nowhere = tmp_path / "gone" / "schedules.db"
    with pytest.raises(StorageError, match="cannot be read or written"):
        Ledger(nowhere)
    assert not nowhere.exists()
