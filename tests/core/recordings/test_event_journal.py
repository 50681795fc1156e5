"""The journal of events: one order for all processes, what is kept, and files that are none."""

import sqlite3
import threading

from platform_daemon.core.schemas.events import DeviceEvent, InterlockEvent
from platform_daemon.core.state import event_journal as module
from platform_daemon.core.state.event_journal import EventJournal, EventReader, read_event


def told(path, *whats):
    journal = EventJournal(path)
    for each in whats:
        journal.tell(each)
    journal.close()


def events(path, after=0, limit=10_000):
    reader = EventReader(path)
    found = [read_event(each) for each in reader.after(after, limit)]
    reader.close()
    return found


def test_what_is_told_is_kept_in_order_with_growing_numbers(tmp_path):
    path = tmp_path / "events.db"
    told(path, InterlockEvent(why="the door is open"), InterlockEvent(why=None))
    told(path, DeviceEvent(device="card", error="gone"))
    found = events(path)
    assert [each.what for each in found] == [
        InterlockEvent(why="the door is open"), InterlockEvent(why=None), DeviceEvent(device="card", error="gone"),
    ]  # fmt: skip
    assert [each.id - found[0].id for each in found] == [0, 1, 2]
    assert events(path, after=found[0].id) == found[1:]


def test_several_writers_make_one_order_without_a_gap(tmp_path):
    path = tmp_path / "events.db"
    journals = [EventJournal(path) for _ in range(3)]

    def write(number):
        for k in range(200):
            journals[number].tell(DeviceEvent(device=str(number), error=str(k)))

    threads = [threading.Thread(target=write, args=(number,)) for number in range(3)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    for each in journals:
        each.close()
    found = events(path)
    assert [each.id - found[0].id for each in found] == list(range(600))
    for number in range(3):
        assert [int(e.what.error) for e in found if e.what.device == str(number)] == list(range(200))


def test_only_the_last_ones_are_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "MOST_KEPT", 50)
    monkeypatch.setattr(module, "_TRIM_EVERY", 10)
    path = tmp_path / "events.db"
    told(path, *(DeviceEvent(device="card", error=str(k)) for k in range(200)))
    reader = EventReader(path)
    assert [read_event(each).what.error for each in reader.after(0, 1000)] == [str(k) for k in range(150, 200)]
    assert reader.forgotten() == reader.base + 150


def test_a_file_that_is_no_journal_is_put_aside_and_numbers_go_on_upwards(tmp_path):
    path = tmp_path / "events.db"
    told(path, InterlockEvent(why=None))
    last = events(path)[-1].id
    for broken in (b"not a database at all" * 100, None):
        if broken is None:
            path.unlink()
            sqlite3.connect(path).executescript("PRAGMA user_version = 99; CREATE TABLE t (a);")
        else:
            path.write_bytes(broken)
        told(path, InterlockEvent(why="again"))
        assert [each.what.why for each in events(path)] == ["again"]
        assert events(path)[0].id > last
    assert len(list(tmp_path.glob("events.db.broken-*"))) == 2


def test_telling_never_waits_for_a_disk_that_refuses(tmp_path):
    journal = EventJournal(tmp_path / "missing" / "events.db")
    for k in range(module.MOST_WAITING + 10):
        journal.tell(DeviceEvent(device="card", error=str(k)))
    (tmp_path / "missing").mkdir()
    journal.close()
    found = events(tmp_path / "missing" / "events.db")
    assert found[-1].what.error == str(module.MOST_WAITING + 9)
    assert len(found) == module.MOST_WAITING
