"""After a crash: acknowledged shots are all there, the series file is whole or absent, live writers are left alone."""

from __future__ import annotations

import multiprocessing
import os
import random
import signal
import time
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
import pytest
import structlog

from drivers.errors import InputError
from platform_daemon.core.recordings.data_folder import open_data_folder
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recovery import recover
from platform_daemon.core.recordings.series_writer import SeriesWriter
from platform_daemon.core.recordings.truth import read_truth
from platform_daemon.core.state.errors import StorageError
from tests.kit.recording_files import header, shot, volts, write_series

KILLS = 16
SHOTS = 4


def crashed(target: Path, count: int, **changes: object) -> Path:
    """A series whose writer went away without a word; returns its staging folder."""
    with SeriesWriter.create(target, header(**changes), overwrite=True) as writer:
        for k in range(1, count + 1):
            writer.add_shot(shot(k))
    return target.with_name(f".{target.name}.shots")


def test_leftover_shots_become_a_series_that_says_it_is_incomplete(tmp_path: Path) -> None:
    staging = crashed(tmp_path / "a.h5", 2, planned_shots=5)
    (staging / "shot_000003.h5.part").write_bytes(b"half")
    (staging / "series.part").write_bytes(b"half")
    assert recover(tmp_path) == [tmp_path / "a.h5"]
    r = open_recording(tmp_path / "a.h5")
    assert r.provenance.incomplete == "stopped after 2 of 5 shots"
    assert [np.array_equal(r.frame_volts(k), volts(k + 1)) for k in range(2)] == [True, True]
    assert [t["f_nat_hz"] for t in read_truth(r.path)] == [214.0, 215.0]
    assert [p.name for p in tmp_path.iterdir()] == ["a.h5"]
    assert recover(tmp_path) == []


def test_the_log_of_a_daemon_says_what_it_has_put_together(tmp_path: Path) -> None:
    with SeriesWriter.create(tmp_path / "a.h5", header()) as writer:
        writer.add_shot(shot(1))
    with structlog.testing.capture_logs() as logged:
        recover(tmp_path)
    (entry,) = (each for each in logged if each["event"] == "series_recovered")
    assert entry["path"] == str(tmp_path / "a.h5")
    assert "killed, crashed or lost its power" in entry["what"]


def test_a_series_that_had_all_its_shots_is_complete_after_recovery(tmp_path: Path) -> None:
    crashed(tmp_path / "a.h5", 3)
    recover(tmp_path)
    assert open_recording(tmp_path / "a.h5").provenance.incomplete is None


def test_recovery_never_replaces_a_file(tmp_path: Path) -> None:
    old = write_series(tmp_path / "a.h5", 3).read_bytes()
    for expected in ("a.recovered.h5", "a.recovered-2.h5"):
        crashed(tmp_path / "a.h5", 1)
        assert recover(tmp_path) == [tmp_path / expected]
    assert (tmp_path / "a.h5").read_bytes() == old


def test_a_crash_between_rename_and_tidying_up_makes_no_second_file(tmp_path: Path) -> None:
    staging = crashed(tmp_path / "a.h5", 3)
    saved = {p.name: p.read_bytes() for p in staging.iterdir()}
    recover(tmp_path)
    staging.mkdir()
    for name, content in saved.items():
        (staging / name).write_bytes(content)
    assert recover(tmp_path) == []
    assert [p.name for p in tmp_path.iterdir()] == ["a.h5"]


def test_a_new_series_first_recovers_what_a_crash_left_for_the_same_file(tmp_path: Path) -> None:
    crashed(tmp_path / "a.h5", 2)
    with SeriesWriter.create(tmp_path / "a.h5", header(), overwrite=True) as writer:
        writer.add_shot(shot(9))
        writer.finish()
    assert open_recording(tmp_path / "a.recovered.h5").frames == 2
    assert np.array_equal(open_recording(tmp_path / "a.h5").frame_volts(0), volts(9))
    crashed(tmp_path / "b.h5", 2)
    with pytest.raises(InputError, match="exists already"):
        SeriesWriter.create(tmp_path / "b.h5", header())
    assert open_recording(tmp_path / "b.h5").frames == 2


def test_a_damaged_shot_is_set_aside_and_counted(tmp_path: Path) -> None:
    staging = crashed(tmp_path / "a.h5", 3)
    damaged = staging / "shot_000002.h5"
    damaged.write_bytes(damaged.read_bytes()[:3000])
    assert recover(tmp_path) == [tmp_path / "a.h5"]
    r = open_recording(tmp_path / "a.h5")
    assert r.provenance.incomplete == "stopped after 2 of 3 shots; 1 shot file could not be read"
    assert [info.shot for info in r.frame_info] == [1, 3]
    assert (tmp_path / "a.h5.shot_000002.unreadable").stat().st_size == 3000


def test_a_recovery_that_fails_leaves_everything_for_the_next_start(tmp_path: Path, monkeypatch) -> None:
    staging = crashed(tmp_path / "a.h5", 2)
    crashed(tmp_path / "b.h5", 1)
    with monkeypatch.context() as patch:
        patch.setattr("platform_daemon.core.recordings.assembly.SPARE_BYTES", 1 << 60)
        assert recover(tmp_path) == []
    assert len(list(staging.glob("shot_*.h5"))) == 2
    assert recover(tmp_path) == [tmp_path / "a.h5", tmp_path / "b.h5"]


def test_a_new_series_whose_leftover_cannot_be_recovered_is_refused_and_gives_the_lock_back(
    tmp_path: Path, monkeypatch
) -> None:
    crashed(tmp_path / "a.h5", 2)
    with monkeypatch.context() as patch:
        patch.setattr("platform_daemon.core.recordings.assembly.SPARE_BYTES", 1 << 60)
        with pytest.raises(StorageError):
            SeriesWriter.create(tmp_path / "a.h5", header())
    assert recover(tmp_path) == [tmp_path / "a.h5"]


def test_empty_and_stale_staging_folders_are_swept_away(tmp_path: Path) -> None:
    (tmp_path / ".a.h5.shots").mkdir()
    for name in (".b.h5.shots-new-00", ".c.h5.shots-new-11"):
        (tmp_path / name).mkdir()
    os.utime(tmp_path / ".b.h5.shots-new-00", (0, 0))
    assert recover(tmp_path) == []
    assert [p.name for p in tmp_path.iterdir()] == [".c.h5.shots-new-11"]
    assert recover(tmp_path / "missing") == []


def _write_until_killed(folder: Path, acknowledged: Connection) -> None:
    for series in range(1000):
        with SeriesWriter.create(folder / f"s{series}.h5", header(planned_shots=SHOTS)) as writer:
            for k in range(1, SHOTS + 1):
                writer.add_shot(shot(k))
                acknowledged.send((series, k))
            writer.finish()


def test_kill_minus_nine_at_any_moment_loses_no_acknowledged_shot(tmp_path: Path) -> None:
    context = multiprocessing.get_context("fork")
    moments = random.Random(1)
    killed_with_leftovers = acknowledged_in_all = 0
    for run in range(KILLS):
        folder = tmp_path / str(run)
        folder.mkdir()
        receive, send = context.Pipe(duplex=False)
        writer = context.Process(target=_write_until_killed, args=(folder, send))
        writer.start()
        send.close()
        receive.poll(10)
        time.sleep(moments.uniform(0, 0.3))
        os.kill(writer.pid, signal.SIGKILL)
        writer.join()
        acknowledged = _drain(receive)
        killed_with_leftovers += any(folder.glob(".*"))
        acknowledged_in_all += sum(acknowledged.values())
        _check(folder, acknowledged)
    assert killed_with_leftovers > KILLS // 2, "the kills came at the wrong moments to prove anything"
    print(f"{KILLS} kills, {killed_with_leftovers} with leftovers, {acknowledged_in_all} shots acknowledged")


def _drain(receive: Connection) -> dict[int, int]:
    acknowledged: dict[int, int] = {}
    try:
        while True:
            series, k = receive.recv()
            acknowledged[series] = k
    except (EOFError, OSError):
        return acknowledged


def _check(folder: Path, acknowledged: dict[int, int]) -> None:
    for path in folder.glob("s*.h5"):
        assert open_recording(path).frames == SHOTS, "a series file appeared before it was whole"
    recover(folder)
    assert not [p for p in folder.iterdir() if p.name.endswith(".shots")]
    for series, shots in acknowledged.items():
        r = open_recording(folder / f"s{series}.h5")
        # One more than acknowledged: killed between the rename and the word of it.
        assert r.frames in (shots, shots + 1)
        for k in range(r.frames):
            assert np.array_equal(r.frame_volts(k), volts(k + 1))
        expected = None if r.frames == SHOTS else f"stopped after {r.frames} of {SHOTS} shots"
        assert r.provenance.incomplete == expected


def test_the_log_of_a_data_folder_is_kept_before_anything_is_put_together(tmp_path: Path) -> None:
    recordings = tmp_path / "recordings"
    recordings.mkdir()
    crashed(recordings / "a.h5", 1)
    seen: list[bool] = []
    folder = open_data_folder(tmp_path, lambda: seen.append((recordings / "a.h5").exists()))
    assert seen == [False]
    assert (folder.recordings / "a.h5").exists()
