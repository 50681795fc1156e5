"""A disk that is full, read-only or forgetful; and what kills leave behind."""

from __future__ import annotations

import contextlib
import errno
import os
from pathlib import Path

import pytest

from drivers.errors import RecordingError
from platform_daemon.core.recordings.data_folder import open_data_folder
from platform_daemon.core.recordings.index import list_recordings, resolve
from platform_daemon.core.recordings.leftovers import kept_series
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recording_index import open_index
from platform_daemon.core.recordings.recovery import recover_all
from platform_daemon.core.recordings.series_writer import SeriesWriter
from platform_daemon.core.state.disk_space import check_free_space
from platform_daemon.core.state.durable import sweep
from platform_daemon.core.state.errors import NotAssembled, StorageError, StorageUnusable
from platform_daemon.core.state.tokens import tokens_in
from tests.kit.recording_files import header, shot, write_minimal, write_series
from tests.kit.small_disk import remount, small_disk


@pytest.fixture
def disk(tmp_path):
    with small_disk(tmp_path / "disk", 4) as folder:
        yield folder


def test_a_folder_with_room_is_as_it_was(tmp_path):
    check_free_space(tmp_path, 1000)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["file", "file/data"])
def test_a_data_folder_that_cannot_be_is_told_with_what_to_do(tmp_path, name):
    (tmp_path / "file").touch()
    assert tokens_in(tmp_path / name).records() == ()
    with pytest.raises(StorageUnusable, match=r"file.*the data folder cannot be used.*Remedy: .*--data folder"):
        open_data_folder(tmp_path / name)


def test_a_data_folder_on_a_read_only_disk_is_told(disk):
    remount(disk, "ro")
    with pytest.raises(StorageUnusable, match=r"cannot be used.*Read-only"):
        open_data_folder(disk / "data")


def test_too_little_room_is_told_with_both_numbers(tmp_path):
    with pytest.raises(StorageUnusable, match=r"may need \d+ MiB, \d+ MiB are free.*Remedy: free the disk"):
        check_free_space(tmp_path, 10**15)


def test_a_small_disk_is_too_small(disk):
    with pytest.raises(StorageUnusable, match=r"[34] MiB are free"):
        check_free_space(disk, 1)


def test_a_disk_that_takes_too_few_files_is_told_before_anything_moves(tmp_path):
    with small_disk(tmp_path / "disk", 300) as disk:
        remount(disk, "nr_inodes=100")
        check_free_space(disk, 1, shots=50)
        with pytest.raises(StorageUnusable, match=r"132 files, the disk takes \d+ more.*Remedy: delete") as told:
            check_free_space(disk, 1, shots=100)
        assert told.value.nothing_moved
        with pytest.raises(StorageUnusable, match="files"):
            SeriesWriter.create(disk / "a.h5", header(planned_shots=100))


def test_a_read_only_disk_is_told_before_anything_moves(disk):
    remount(disk, "ro")
    with pytest.raises(StorageUnusable, match=r"Read-only file system.*Remedy") as told:
        check_free_space(disk, 1)
    assert told.value.nothing_moved


def test_a_disk_that_does_not_keep_what_it_is_given_is_told(tmp_path, monkeypatch):
    def fail(descriptor):
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(StorageUnusable, match="Input/output error"):
        check_free_space(tmp_path, 1)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_gone_is_told(tmp_path):
    with pytest.raises(StorageUnusable, match="No such file"):
        check_free_space(tmp_path / "gone", 1)


def test_shots_that_cannot_be_put_together_are_kept_listed_and_put_together_once_there_is_room(disk):
    with SeriesWriter.create(disk / "a.h5", header(planned_shots=None)) as series:
        for k in (1, 2, 3):
            series.add_shot(shot(k))
        assert kept_series(disk) == []  # somebody still writes to it
        with pytest.raises(NotAssembled, match=r"3 acknowledged shots are kept.*recordings/recover"):
            series.finish()
    assert not (disk / "a.h5").exists()
    (kept,) = kept_series(disk)
    assert (kept.id, "3 acknowledged" in str(kept.error)) == ("a", True)
    found = recover_all(disk)
    assert (found.made, [path.name for path, _ in found.failed]) == ((), ["a.h5"])
    assert isinstance(found.failed[0][1], NotAssembled)
    remount(disk, "size=64m")
    assert [path.name for path in recover_all(disk).made] == ["a.h5"]
    assert open_recording(disk / "a.h5").frames == 3
    assert kept_series(disk) == []


@pytest.mark.long
def test_a_disk_that_fills_up_within_a_series_keeps_what_was_acknowledged(disk):
    acknowledged = 0
    with SeriesWriter.create(disk / "a.h5", header(planned_shots=None)) as series:
        (disk / "other").write_bytes(bytes(3 << 20))
        with contextlib.suppress(StorageError):
            for k in range(1, 10_000):
                acknowledged = series.add_shot(shot(k))
        with pytest.raises(StorageError, match="No space left"):
            series.add_shot(shot(1))
    (disk / "other").unlink()
    remount(disk, "size=200m")
    recover_all(disk)
    assert open_recording(disk / "a.h5").frames == acknowledged > 0


def test_part_files_of_dead_writers_are_swept_and_nothing_else(tmp_path):
    dead = 2**22 + 1  # larger than any process id
    names = [f".a.json.{dead}-0123abcd.part", f".a.json.{os.getpid()}-0123abcd.part", "a.json", ".a.part", ".x.shots"]
    for name in names:
        (tmp_path / name).write_text("{}")
    assert [p.name for p in sweep([tmp_path])] == names[:1]
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted(names[1:])


def test_a_data_folder_is_swept_when_it_is_opened(tmp_path):
    (tmp_path / "jobs").mkdir()
    left = tmp_path / "jobs" / f".a.json.{2**22 + 1}-0123abcd.part"
    left.write_text("{")
    open_data_folder(tmp_path)
    assert not left.exists()


def test_a_link_that_leads_out_of_the_folder_is_not_served(tmp_path):
    outside, folder = tmp_path / "outside", tmp_path / "folder"
    outside.mkdir()
    folder.mkdir()
    write_series(outside / "secret.h5")
    write_series(folder / "own.h5")
    (folder / "secret.h5").symlink_to(outside / "secret.h5")
    (folder / "other_name.h5").symlink_to("own.h5")
    assert [e.id for e in list_recordings(folder).recordings] == ["other_name", "own"]
    with pytest.raises(Exception, match="no recording 'secret'"):
        resolve(folder, "secret")


@pytest.mark.parametrize("name", ["ü ö.h5", "a b'c\".h5", "-rf.h5", "%2e%2e.h5", "a\nb.h5", "x" * 200 + ".h5"])
def test_odd_names_are_listed_and_found(tmp_path, name):
    write_series(tmp_path / "a.h5")
    Path(tmp_path / "a.h5").rename(tmp_path / name)
    (found,) = list_recordings(tmp_path).recordings
    assert resolve(tmp_path, found.id).name == name


def test_a_name_that_is_no_text_is_told_and_hides_no_other_file(tmp_path):
    write_series(tmp_path / "a.h5")
    odd = tmp_path / os.fsdecode(b"bad\xff.h5")
    odd.write_bytes((tmp_path / "a.h5").read_bytes())
    found = list_recordings(tmp_path)
    assert [e.id for e in found.recordings] == ["a"]
    assert [(b.id, "rename it" in str(b.error)) for b in found.broken] == [("bad\\xff", True)]
    assert list_recordings(tmp_path, after="a.h5").broken == ()
    with contextlib.closing(open_index(tmp_path)) as index:
        assert index.update(lambda path: None).looked == 1


@pytest.mark.parametrize("spoil", ["unreadable", "read-only"])
def test_shots_of_which_nobody_can_tell_whether_they_are_written_are_left_alone_and_hide_nothing(disk, spoil):
    remount(disk, "size=64m")
    for name in ("b.h5", "a.h5"):
        with SeriesWriter.create(disk / name, header(planned_shots=None)) as series:
            series.add_shot(shot(1))
            if name == "b.h5":
                series.finish()
    lock = disk / ".a.h5.shots" / "lock"
    if spoil == "unreadable":
        lock.unlink()
        lock.mkdir()
    else:
        remount(disk, "ro")
    assert [each.id for each in list_recordings(disk).recordings] == ["b"]
    assert [kept.id for kept in kept_series(disk)] == ([] if spoil == "unreadable" else ["a"])
    assert recover_all(disk).made == ()


def test_an_id_and_a_name_that_look_the_same_are_the_same(tmp_path):
    made = write_minimal(tmp_path / "Ju\u0308rgen.h5")
    assert resolve(tmp_path, "J\u00fcrgen") == made
    with pytest.raises(RecordingError, match=r"no such file.*looks like it.*Ju\\u0308rgen"):
        open_recording(tmp_path / "J\u00fcrgen.h5")
    exact = write_minimal(tmp_path / "J\u00fcrgen.h5")
    assert resolve(tmp_path, "J\u00fcrgen") == exact
