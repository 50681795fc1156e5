"""SQLite files: made whole or not at all, refused or replaced where damaged, shared by threads and processes."""

import multiprocessing
import os
import signal
import sqlite3
import threading
import time

import pytest

from platform_daemon.core.state import database as module
from platform_daemon.core.state.database import DamagedDatabase, Database, Schema, WhenDamaged, tables
from platform_daemon.core.state.errors import StorageError

TABLE = "CREATE TABLE t (a INTEGER PRIMARY KEY, b TEXT)"


def schema(when_damaged=WhenDamaged.REFUSE, journal="WAL", version=1):
    return Schema(
        title="the file of a test",
        application_id=7,
        version=version,
        create=tables(TABLE),
        when_damaged=when_damaged,
        check_content=True,
        journal=journal,
        remedy="do something",
    )


@pytest.fixture
def path(tmp_path):
    return tmp_path / "t.db"


@pytest.mark.parametrize("journal", ["WAL", "TRUNCATE"])
def test_what_was_written_is_read_by_another_connection(path, journal):
    first, second = Database(path, schema(journal=journal)), Database(path, schema(journal=journal))
    before = second.changed_by_others
    with first.transaction() as sql:
        sql.execute("INSERT INTO t VALUES (1, 'x')")
    first.execute("INSERT INTO t VALUES (?, ?)", (2, "y"))
    assert second.rows("SELECT * FROM t") == [(1, "x"), (2, "y")]
    assert second.changed_by_others != before
    first.close()
    first.close()
    second.close()


def add_then(file, then):
    with file.transaction() as sql:
        sql.execute("INSERT INTO t VALUES (1, 'x')")
        then(sql)


def test_a_transaction_that_fails_changes_nothing(path):
    file = Database(path, schema())
    with pytest.raises(StorageError, match=r"t\.db.*cannot be read or written.*UNIQUE.*do something"):
        add_then(file, lambda sql: sql.execute("INSERT INTO t VALUES (1, 'y')"))
    with pytest.raises(ZeroDivisionError):
        add_then(file, lambda sql: 1 / 0)
    assert file.rows("SELECT * FROM t") == []


@pytest.mark.parametrize("content", [b"", b"x", b"no database" * 500])
def test_a_precious_file_that_is_damaged_is_refused_and_stays(path, content):
    path.write_bytes(content)
    with pytest.raises(DamagedDatabase, match=r"t\.db.*the file of a test is damaged.*put back a copy"):
        Database(path, schema())
    assert path.read_bytes() == content


def test_a_precious_file_whose_log_is_left_without_it_is_refused(path):
    path.with_name("t.db-wal").write_bytes(b"x")
    with pytest.raises(DamagedDatabase, match="the file is gone, its log is there"):
        Database(path, schema())


def test_an_empty_journal_of_a_file_that_was_moved_away_does_not_keep_a_new_one_from_being_made(path):
    file = Database(path, schema(journal="TRUNCATE"))
    file.execute("INSERT INTO t VALUES (1, 'x')")
    file.close()
    path.with_name("t.db-journal").touch()
    path.unlink()
    assert Database(path, schema(journal="TRUNCATE")).rows("SELECT * FROM t") == []


@pytest.mark.parametrize("content", [b"", b"no database" * 500])
def test_a_file_that_can_be_made_again_is_replaced_and_one_of_value_to_a_reader_is_set_aside(path, content):
    for policy, left in ((WhenDamaged.DELETE, 0), (WhenDamaged.SET_ASIDE, 1)):
        path.write_bytes(content)
        file = Database(path, schema(policy))
        assert file.rows("SELECT * FROM t") == []
        file.close()
        assert len(list(path.parent.glob("t.db.broken-*"))) == left
        module.delete(path)


def test_a_file_of_another_version_counts_as_damaged(path):
    Database(path, schema()).close()
    with pytest.raises(DamagedDatabase, match="it is no file of a test of version 2"):
        Database(path, schema(version=2))


def test_a_precious_file_that_is_moved_away_is_missed_at_once(path):
    file = Database(path, schema())
    path.rename(path.with_name("elsewhere"))
    for use in (lambda: file.rows("SELECT 1"), lambda: file.execute("INSERT INTO t VALUES (1, 'x')")):
        with pytest.raises(StorageError, match="was taken away"):
            use()


def test_a_closed_file_says_so(path):
    file = Database(path, schema())
    file.close()
    for use in (lambda: file.rows("SELECT 1"), lambda: file.execute("INSERT INTO t VALUES (1, 'x')")):
        with pytest.raises(StorageError, match="closed"):
            use()


def while_the_disk_is_busy(path, work, count):
    """Threads that begin their work while another connection writes."""
    other = sqlite3.connect(path, isolation_level=None)
    other.execute("BEGIN IMMEDIATE")
    threads = [threading.Thread(target=work, args=(k,)) for k in range(count)]
    for each in threads:
        each.start()
    time.sleep(0.5)
    other.execute("COMMIT")
    other.close()
    for each in threads:
        each.join()


def test_threads_that_wait_for_the_disk_share_transactions(path, monkeypatch):
    file, begun, transaction = Database(path, schema()), [], Database.transaction
    monkeypatch.setattr(Database, "transaction", lambda self: (begun.append(1), transaction(self))[1])
    while_the_disk_is_busy(path, lambda k: file.execute("INSERT INTO t VALUES (?, 'x')", (k,)), 50)
    assert len(begun) <= 5
    assert len(file.rows("SELECT * FROM t")) == 50


def test_each_of_the_threads_that_share_a_transaction_hears_that_it_failed(path):
    file, refused = Database(path, schema()), []

    def write(number):
        try:
            file.execute("INSERT INTO nowhere VALUES (1)")
        except StorageError as error:
            refused.append(str(error))

    while_the_disk_is_busy(path, write, 5)
    assert len(refused) == 5
    file.execute("INSERT INTO t VALUES (1, 'x')")


def _write_for_ever(path, journal, acknowledged):
    file = Database(path, schema(journal=journal))
    for number in range(file.rows("SELECT coalesce(max(a), 0) FROM t")[0][0] + 1, 10**6):
        file.execute("INSERT INTO t VALUES (?, ?)", (number, "x" * 5000))
        acknowledged.send(number)


@pytest.mark.parametrize("journal", ["WAL", "TRUNCATE"])
def test_what_was_acknowledged_outlives_kills(path, journal):
    context = multiprocessing.get_context("fork")
    last = 0
    for kill in range(8):
        ours, theirs = context.Pipe(duplex=False)
        process = context.Process(target=_write_for_ever, args=(path, journal, theirs))
        process.start()
        theirs.close()
        for _ in range(3 + 5 * kill):
            last = ours.recv()
        os.kill(process.pid, signal.SIGKILL)
        try:
            while True:
                last = ours.recv()
        except EOFError:
            process.join()
        file = Database(path, schema(journal=journal))
        count, newest = file.rows("SELECT count(*), max(a) FROM t")[0]
        assert count == newest
        assert last <= newest <= last + 1
        file.close()


def test_two_processes_that_make_one_file_at_once_have_the_same(path):
    files = []
    threads = [threading.Thread(target=lambda: files.append(Database(path, schema()))) for _ in range(8)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    for number, file in enumerate(files):
        file.execute("INSERT INTO t VALUES (?, 'x')", (number,))
    with sqlite3.connect(path) as sql:
        assert sql.execute("SELECT count(*) FROM t").fetchone() == (8,)
    assert not list(path.parent.glob("*.part"))
