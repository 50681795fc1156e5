"""Schedules whose ledger cannot be opened when the daemon begins, or is taken away while it runs."""

import errno
import json
from pathlib import Path

import pytest

from platform_daemon.core.state.database import DamagedDatabase
from platform_daemon.core.state.errors import StorageError
from platform_daemon.features.schedules import schedules
from platform_daemon.features.schedules.ledger import Ledger
from platform_daemon.features.schedules.schedules import Schedules, suspension_flag
from platform_daemon.features.schedules.schema import ScheduleRequest
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
        self.made = []

    def ledger(self, path):
        if self.refuses:
            raise StorageError("the disk is full")
        return Ledger(path)

    def schedules(self):
        self.made.append(Schedules(self.path, Nobody()))
        return self.made[-1]

    def end(self):
        for each in self.made:
            each.stop_starting()
            each.close()


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(schedules, "_STEP_S", 0.02)
    made = Folder(tmp_path)
    monkeypatch.setattr(schedules, "Ledger", made.ledger)
    first = made.schedules()
    first.start()
    first.add(REQUEST)
    made.end()
    yield made
    made.end()


def can_be_asked(kept):
    try:
        kept.list()
    except StorageError:
        return False
    return True


def test_a_disk_that_refuses_is_tried_again_and_a_stop_meanwhile_holds(folder):
    folder.refuses, kept = True, folder.schedules()
    kept.start()
    with pytest.raises(StorageError, match="the disk is full"):
        kept.list()
    assert "the disk is full" in str(kept.pause_all(STOPPED))
    folder.refuses = False
    wait_for(lambda: can_be_asked(kept))
    assert kept.list()[0].reason == STOPPED
    kept.step()
    assert not suspension_flag(folder.path).is_set
    folder.end()
    again = folder.schedules()
    again.start()
    assert [(each.active, each.reason) for each in again.list()] == [(False, STOPPED)]
    again.resume(again.list()[0].id)
    folder.end()
    last = folder.schedules()
    last.start()
    last.step()
    assert [each.active for each in last.list()] == [True]


def test_a_stop_while_the_ledger_is_damaged_holds_once_a_copy_is_put_back(folder):
    whole = folder.path.read_bytes()
    folder.path.write_bytes(whole[:3000])
    kept = folder.schedules()
    kept.start()
    assert "cut off after 3000 bytes" in str(kept.pause_all(STOPPED))
    with pytest.raises(DamagedDatabase, match="put back a copy"):
        kept.list()
    folder.end()
    folder.path.write_bytes(whole)
    again = folder.schedules()
    again.start()
    assert [each.active for each in again.list()] == [False]


def test_a_stop_between_two_tries_is_told_to_what_is_opened_then(folder):
    folder.refuses, kept = True, folder.schedules()
    kept.start()
    kept.suspend(STOPPED)
    folder.refuses = False
    wait_for(lambda: can_be_asked(kept))
    assert kept.list()[0].reason == STOPPED
    assert kept.pause_all(STOPPED) is None
    assert not suspension_flag(folder.path).is_set


def test_one_that_is_told_to_end_while_it_opens_them_lets_them_go(folder, monkeypatch):
    made = []

    def told_to_end(path):
        made.append(Ledger(path))
        kept.stop_starting()
        return made[0]

    kept = folder.schedules()
    monkeypatch.setattr(schedules, "Ledger", told_to_end)
    kept.start()
    kept.close()
    assert not can_be_asked(kept)
    with pytest.raises(StorageError):
        made[0].schedules()


def test_a_disk_that_does_not_even_answer_is_tried_again(folder, monkeypatch):
    asked, exists = [], Path.exists

    def refused(path):
        if path == folder.path and len(asked) < 2:
            asked.append(path)
            raise OSError(errno.EIO, "Input/output error")
        return exists(path)

    monkeypatch.setattr(Path, "exists", refused)
    kept = folder.schedules()
    kept.start()
    with pytest.raises(StorageError, match="Input/output error"):
        kept.list()
    wait_for(lambda: can_be_asked(kept))


def test_a_ledger_that_is_taken_away_is_told_and_nothing_is_written_into_nowhere(folder):
    kept = folder.schedules()
    kept.start()
    away = folder.path.with_name("elsewhere.db")
    folder.path.rename(away)
    for ask in (kept.list, kept.step, lambda: kept.add(REQUEST)):
        with pytest.raises(StorageError, match="taken away"):
            ask()
    away.rename(folder.path)
    assert len(kept.list()) == 1


def test_a_ledger_is_begun_whole_or_not_at_all(tmp_path):
    path = tmp_path / "schedules.db"
    (tmp_path / f".schedules.db.{2**22 + 1}-0123abcd.part").write_bytes(b"of one that died here")
    Ledger(path).close()
    assert [each.name for each in tmp_path.iterdir()] == ["schedules.db"]
    nowhere = tmp_path / "gone" / "schedules.db"
    with pytest.raises(StorageError, match="cannot be read or written"):
        Ledger(nowhere)
    assert not nowhere.exists()
