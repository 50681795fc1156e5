"""Versions: numbered from 1, whole, and never overwritten, whoever adds them at the same time."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from platform_daemon.core.state.durable import write_file, write_new_file
from platform_daemon.core.state.errors import StorageError
from platform_daemon.core.state.versioned import VersionedFolder


def add(folder: VersionedFolder, name: str) -> int:
    return folder.add(name, ".txt", lambda number, stem: f"{stem} is {number}".encode()).number


def test_many_at_once_get_a_number_each_and_nothing_else_stays(tmp_path: Path) -> None:
    folder = VersionedFolder(tmp_path / "new", r"\.txt")
    with ThreadPoolExecutor(8) as pool:
        numbers = list(pool.map(lambda _: add(folder, "a"), range(24)))
    assert sorted(numbers) == list(range(1, 25))
    assert [v.path.read_text() for v in folder.versions("a")] == [f"a@{n} is {n}" for n in range(1, 25)]
    assert len(list(folder.folder.iterdir())) == 24


def test_names_that_begin_alike_and_foreign_files_are_told_apart(tmp_path: Path) -> None:
    folder = VersionedFolder(tmp_path, r"_\d{8}\.h5")
    for name in ("a@1_20260101.h5", "a@10_20260101.h5", "a@9_20251231.h5", "a-b@3_20260101.h5", "a@0_20260101.h5",
                 "a@2.h5", "a@11_20260101.h5.part", ".a@12_20260101.h5", "b.txt"):  # fmt: skip
        (tmp_path / name).write_text("")
    assert [(v.name, v.number) for v in folder.versions()] == [("a", 1), ("a", 9), ("a", 10), ("a-b", 3)]
    assert folder.add("a", "_20260102.h5", lambda number, stem: b"").path.name == "a@11_20260102.h5"


def test_what_cannot_be_made_leaves_nothing(tmp_path: Path) -> None:
    def broken(number: int, stem: str) -> bytes:
        raise ValueError(stem)

    with pytest.raises(ValueError, match="a@1"):
        VersionedFolder(tmp_path, r"\.txt").add("a", ".txt", broken)
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_none_is_a_storage_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(StorageError, match="disk refused"):
        add(VersionedFolder(tmp_path / "file" / "below", r"\.txt"), "a")
    for write in (write_file, write_new_file):
        with pytest.raises(StorageError, match="No such file"):
            write(tmp_path / "none" / "a", b"")
        with pytest.raises(StorageError, match="Not a directory"):
            write(tmp_path / "file" / "a", b"")


def test_a_new_file_never_takes_the_place_of_another_and_write_file_does(tmp_path: Path) -> None:
    target = tmp_path / "a"
    assert write_new_file(target, b"first")
    assert not write_new_file(target, b"second")
    assert target.read_bytes() == b"first"
    write_file(target, b"third")
    assert target.read_bytes() == b"third"
    assert [p.name for p in tmp_path.iterdir()] == ["a"]
