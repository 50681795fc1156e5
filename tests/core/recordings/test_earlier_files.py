"""A data folder of an earlier version: jobs and alarms are imported, whatever happens in between; no file is lost."""

import json
import os
import shutil
from pathlib import Path

import pytest

from platform_daemon.core.jobs.job_records import JobRecords
from platform_daemon.core.recordings.data_folder import open_data_folder
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.service.job_view import JobView
from platform_daemon.core.state import earlier_files
from platform_daemon.core.state.audit import audit_log_in
from platform_daemon.core.state.database import Database
from platform_daemon.core.state.earlier_files import import_earlier_files
from platform_daemon.core.state.state_file import STATE_SCHEMA
from platform_daemon.features.alarms.board import AlarmBoard
from platform_daemon.features.schedules.ledger import Ledger
from tests.kit.data import DATA
from tests.kit.small_disk import remount, small_disk
from tests.kit.stored_jobs import job_texts

WAITING = "acquisition-20261126T173804-3b7a0b"


@pytest.fixture
def folder(tmp_path):
    return Path(shutil.copytree(DATA / "data_folder_before_state", tmp_path / "data"))


@pytest.fixture
def earlier(folder):
    return {path.stem: path.read_text() for path in (folder / "jobs").iterdir()}


def opened(folder):
    data = open_data_folder(folder)
    data.lock.close()
    return data


def left_behind(folder):
    return {path.relative_to(folder / "before-state").as_posix() for path in (folder / "before-state").rglob("*.json")}


def test_jobs_alarms_schedules_and_the_audit_log_are_there_after_the_first_start(folder, earlier):
    data = opened(folder)
    assert job_texts(folder) == earlier
    records = JobRecords(data.state)
    waiting = frozenset({"acquisition"})
    found = {job.identifier: job for job in records.load(waiting=waiting)}
    assert found.keys() == earlier.keys()
    assert {name: str(job.state) for name, job in found.items()} == {
        name: json.loads(text)["state"] for name, text in earlier.items()
    }
    assert found[WAITING].state is JobState.QUEUED
    (alarm,) = AlarmBoard(data.state, lambda event: None).all()
    assert (alarm.name, alarm.acknowledged_by) == ("idle", "anna")
    ledger = Ledger(data.schedules)
    nightly, chain = ledger.schedules()
    assert (nightly.off, chain.off) == ("paused", None)
    assert [row.state for row in ledger.rows(nightly.id)][:2] == ["run", "skipped"]
    ledger.close()
    assert len(audit_log_in(folder).entries()) > 5


def test_the_key_identifier_of_an_earlier_record_is_read_and_becomes_id_when_the_job_is_saved(folder, earlier):
    assert all(json.loads(text)["identifier"] == name for name, text in earlier.items())
    records = JobRecords(opened(folder).state)
    for name in earlier:
        job = records.one(name)
        assert JobView.of(job).to_wire()["record"].id == name
        records.save(job)
    for name, text in job_texts(folder).items():
        saved, before = json.loads(text), json.loads(earlier[name])
        assert saved == {"id": before.pop("identifier"), **before}
        assert records.one(name).identifier == name


def test_the_earlier_files_are_kept_apart_and_are_not_imported_again(folder, earlier):
    data = opened(folder)
    assert left_behind(folder) == {"alarms.json", *(f"jobs/{name}.json" for name in earlier)}
    for name, text in earlier.items():
        assert (folder / f"before-state/jobs/{name}.json").read_text() == text
    assert not (folder / "jobs").exists()
    records = JobRecords(data.state)
    job = records.one(WAITING)
    job.request_cancel()
    records.save(job)
    opened(folder)
    assert records.one(WAITING).state is JobState.CANCELLED


def test_an_import_that_is_killed_anywhere_is_made_again(folder, earlier, monkeypatch):
    whole = 0
    replace = os.replace
    for number in range(len(earlier) + 2):
        copy = Path(shutil.copytree(folder, folder.with_name(f"copy{number}")))
        calls = iter(range(number))

        def killed(*names, calls=calls):
            if next(calls, None) is None:
                raise KeyboardInterrupt
            replace(*names)

        with monkeypatch.context() as patched:
            patched.setattr(earlier_files.os, "replace", killed)
            try:
                import_earlier_files(copy)
                whole += 1
            except KeyboardInterrupt:
                pass
        records = JobRecords(copy / "state.sqlite")
        job = records.one(WAITING)
        job.request_cancel()  # after the rows were added, and before the next start
        records.save(job)
        opened(copy)
        assert job_texts(copy).keys() == earlier.keys()
        assert records.one(WAITING).state is JobState.CANCELLED
        assert left_behind(copy) == {"alarms.json", *(f"jobs/{name}.json" for name in earlier)}
    assert whole == 1


def test_one_that_is_killed_within_its_transaction_adds_nothing(folder, earlier, monkeypatch):
    with monkeypatch.context() as patched:
        patched.setattr(earlier_files, "_alarms", lambda path: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            import_earlier_files(folder)
    assert job_texts(folder) == {}
    assert {path.stem for path in (folder / "jobs").iterdir()} == earlier.keys()
    opened(folder)
    assert job_texts(folder) == earlier


def test_records_that_are_cut_off_keep_their_id_and_their_content(folder, earlier):
    (folder / "jobs" / "fit-1.json").write_text('{"kind": "fi')
    (folder / "jobs" / "fit-2.json").write_bytes(b"")
    data = opened(folder)
    records = JobRecords(data.state)
    assert records.has("fit-1")
    assert records.has("fit-2")
    for name in ("fit-1", "fit-2"):
        with pytest.raises(ValueError, match="valid"):
            records.one(name)
    assert len(records.load(waiting=frozenset({"acquisition"}))) == len(earlier)
    assert job_texts(folder)["fit-1"] == '{"kind": "fi'


def test_a_disk_without_room_leaves_all_files_and_they_are_imported_once_there_is_room(earlier, folder, tmp_path):
    with small_disk(tmp_path / "disk", 1) as disk:
        data = disk / "data"
        shutil.copytree(folder, data)
        filler = disk / "filler"
        with filler.open("wb", buffering=0) as file:
            try:
                while True:
                    file.write(bytes(4096))
            except OSError:
                pass
        import_earlier_files(data)
        assert {path.stem for path in (data / "jobs").iterdir()} == earlier.keys()
        assert (data / "alarms.json").exists()
        filler.unlink()
        remount(disk, "size=8m")
        opened(data)
        assert job_texts(data) == earlier


def test_a_state_that_is_damaged_is_not_replaced_and_earlier_files_stay(folder, earlier):
    (folder / "state.sqlite").write_bytes(b"no database")
    opened(folder)
    assert (folder / "state.sqlite").read_bytes() == b"no database"
    assert {path.stem for path in (folder / "jobs").iterdir()} == earlier.keys()


def test_jobs_that_an_earlier_version_makes_afterwards_are_imported_too(folder, earlier):
    opened(folder)
    (folder / "jobs").mkdir()
    text = earlier[WAITING].replace(WAITING, "acquisition-20270101T000000-aaaaaa")
    (folder / "jobs" / "acquisition-20270101T000000-aaaaaa.json").write_text(text)
    opened(folder)
    with Database(folder / "state.sqlite", STATE_SCHEMA).transaction() as sql:
        assert sql.execute("SELECT count(*) FROM jobs").fetchone()[0] == len(earlier) + 1
