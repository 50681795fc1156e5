"""A generic NeXus viewer must show the ring-down without being told where it is."""

from __future__ import annotations

from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path

import h5py
import numpy as np
from nexusformat.nexus import nxload

from platform_daemon.core.recordings.series_writer import SeriesWriter
from tests.kit.nexus_rules import violations
from tests.kit.recording_files import SEQUENCE, fit_table, header, shot, volts, write_series


def test_a_series_obeys_the_rules(tmp_path: Path) -> None:
    assert violations(write_series(tmp_path / "a.h5", fits=(fit_table(3),))) == []


def test_a_shot_file_obeys_the_rules_too(tmp_path: Path) -> None:
    with SeriesWriter.create(tmp_path / "a.h5", header()) as writer:
        writer.add_shot(shot(1))
        assert violations(next((tmp_path / ".a.h5.shots").glob("*.h5"))) == []


def test_the_checker_sees_what_it_is_there_for(tmp_path: Path) -> None:
    path = write_series(tmp_path / "a.h5")
    with h5py.File(path, "a") as h5:
        del h5["/entry/ring_down/time"], h5["/entry/ring_down/frame"].attrs["units"], h5["/frames"].attrs["NX_class"]
        h5.attrs["default"] = "data"
        del h5["/entry/title"]
    assert len(violations(path)) == 5


def test_nexusformat_finds_the_default_plot(tmp_path: Path) -> None:
    root = nxload(str(write_series(tmp_path / "a.h5")))
    plot = root.get_default()
    assert plot.nxpath == "/entry/ring_down"
    assert plot.nxsignal.nxname == "volts"
    assert plot.nxsignal.attrs["units"] == "V"
    assert np.array_equal(plot.nxsignal.nxvalue[1], volts(2))
    assert [axis.nxname for axis in plot.nxaxes] == ["frame", "channel", "time"]


def test_the_plot_is_the_data_and_its_time_zero_the_first_rx_sample(tmp_path: Path) -> None:
    with h5py.File(write_series(tmp_path / "a.h5")) as h5:
        assert h5["/entry/ring_down/volts"] == h5["/data"]
        assert h5["/data"].attrs["interpretation"] == "spectrum"
        time = h5["/entry/ring_down/time"][()]
        assert time[SEQUENCE.rx_start] == 0.0
        assert time[-1] == (SEQUENCE.rx_samples - 1) / SEQUENCE.rate_hz


def end_of(path: Path) -> datetime:
    with h5py.File(path) as h5:
        return datetime.fromisoformat(h5["/entry/end_time"][()].decode())


def test_a_measurement_ends_with_the_last_sample_of_its_last_shot(tmp_path: Path) -> None:
    takes = timedelta(seconds=SEQUENCE.total / SEQUENCE.rate_hz)
    whole, short = write_series(tmp_path / "a.h5"), write_series(tmp_path / "b.h5", 2)
    assert end_of(whole) == datetime.fromisoformat(shot(3).time_stamp) + takes
    assert end_of(short) == datetime.fromisoformat(shot(2).time_stamp) + takes
    with SeriesWriter.go_on(short, header()) as writer:
        writer.add_shot(shot(9))
        writer.finish()
    assert end_of(short) == datetime.fromisoformat(shot(9).time_stamp) + takes
    last = tmp_path / "c.h5"
    with SeriesWriter.create(last, header()) as writer:
        writer.add_shot(replace(shot(1), time_stamp="9999-12-31T23:59:59.999999+00:00"))
        writer.finish()
    assert end_of(last).year == 9999
