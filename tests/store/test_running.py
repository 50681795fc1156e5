"""Frames of a series that runs, while its shots are put together and while it is gone on with."""

import pytest

from drivers.errors import RecordingError
from platform_daemon.store import SeriesWriter, open_recording, read_frame
from platform_daemon.store.errors import UnknownRecording
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
