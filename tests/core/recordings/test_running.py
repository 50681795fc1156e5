"""Frames of a series that runs, while its shots are put together and while it is gone on with."""

import pytest

from drivers.errors import RecordingError
from platform_daemon.core.recordings import staging as staging_module
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.running import describe_running, read_frame
from platform_daemon.core.recordings.series_writer import SeriesWriter
from platform_daemon.core.state.errors import UnknownRecording
from tests.kit.recording_files import header, shot


def numbered(stored):
    return open_recording(stored.path).frame_info[stored.frame].shot


def test_a_frame_is_found_though_its_shots_are_put_together_while_it_is_read(tmp_path):
    with SeriesWriter.create(tmp_path / "a.h5", header()) as series:
        series.add_shot(shot(0))
        series.add_shot(shot(1))
        assert read_frame(tmp_path, "a", 1, numbered) == 2
        tried = []

        def late(stored):
            tried.append(stored.path.name)
            if len(tried) == 1:
                series.finish()
            return numbered(stored)

        assert read_frame(tmp_path, "a", 1, late) == 2
    assert tried == ["shot_000002.h5", "a.h5"]
    with pytest.raises(UnknownRecording):
        read_frame(tmp_path, "b", 0, numbered)
    (tmp_path / "a.h5").write_bytes(b"no recording")
    with pytest.raises(RecordingError):
        read_frame(tmp_path, "a", 0, numbered)


def test_the_new_shots_of_a_series_that_is_gone_on_with_can_be_read_before_its_end(tmp_path):
    with SeriesWriter.create(tmp_path / "a.h5", header()) as series:
        series.add_shot(shot(0))
        series.finish(incomplete="stopped")
    with SeriesWriter.go_on(tmp_path / "a.h5", header()) as series:
        series.add_shot(shot(1))
        assert [read_frame(tmp_path, "a", k, numbered) for k in (0, 1)] == [1, 2]
        series.finish()


def test_shots_that_are_being_deleted_are_not_taken_for_all_of_them(tmp_path, monkeypatch):
    seen = []
    remove = staging_module.shutil.rmtree

    def slowly(folder, **options):
        for shot_file in sorted(folder.glob("shot_*.h5"))[:1]:
            shot_file.unlink()
        seen.append([read_frame(tmp_path, "a", k, numbered) for k in (0, 1)])
        seen.append(describe_running(tmp_path, "a"))
        remove(folder, **options)

    monkeypatch.setattr(staging_module.shutil, "rmtree", slowly)
    with SeriesWriter.create(tmp_path / "a.h5", header()) as series:
        series.add_shot(shot(0))
        series.add_shot(shot(1))
        series.finish()
    assert seen == [[1, 2], None]
    assert sorted(each.name for each in tmp_path.iterdir()) == ["a.h5"]


def test_a_series_that_is_put_together_while_it_is_described_is_no_damaged_one(tmp_path, monkeypatch):
    with SeriesWriter.create(tmp_path / "a.h5", header()) as series:
        series.add_shot(shot(0))
        series.add_shot(shot(1))

        def late(path):
            series.finish()
            return open_recording(path)

        monkeypatch.setattr("platform_daemon.core.recordings.running.open_recording", late)
        assert describe_running(tmp_path, "a") is None


def test_a_recording_never_seems_to_hold_less_while_its_shots_are_taken_up(tmp_path, monkeypatch):
    with SeriesWriter.create(tmp_path / "a.h5", header()) as series:
        series.add_shot(shot(0))
        series.add_shot(shot(1))
        series.finish(incomplete="stopped")
    frames = []
    add = SeriesWriter.add_shot

    def added(self, one):
        number = add(self, one)
        found = describe_running(tmp_path, "a")
        frames.append(None if found is None else found.frames)
        return number

    monkeypatch.setattr(SeriesWriter, "add_shot", added)
    with SeriesWriter.go_on(tmp_path / "a.h5", header()) as series:
        series.add_shot(shot(2))
        series.finish()
    assert frames == [None, 2, 3]
