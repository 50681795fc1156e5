"""`/step`: frames of the steps of a procedure, grouped, with what each was made with, also where windows differ."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr

from drivers.errors import InputError, RecordingError
from platform_daemon.core.recordings.fit_joining import NOT_FITTED, joined_fits
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recording import StepLabel
from platform_daemon.core.recordings.recovery import recover
from platform_daemon.core.recordings.series_writer import SeriesWriter
from tests.kit.fit_tables import read_fits
from tests.kit.nexus_rules import violations
from tests.kit.recording_files import SEQUENCE, fit_table, header, shot, volts, write_series

LONG = replace(SEQUENCE, tx_samples=30, rx_samples=120)
LABELS = (StepLabel(1, {"field_ut": 50.0, "axis": "x"}), StepLabel(2, {"field_ut": 60.0}))


def stepped(target: Path, *, finish: bool = True) -> Path:
    """A short step and a longer one."""
    first = header(planned_shots=2)
    with SeriesWriter.create(target, first) as writer:
        writer.add_shot(replace(shot(1), step=LABELS[0]))
        writer.go_on_with(replace(first, sequence=LONG))
        longer = np.arange(3 * LONG.total, dtype=np.float32).reshape(3, -1) / 1e3 + 1
        writer.add_shot(replace(shot(2), volts=longer, step=LABELS[1]))
        if finish:
            writer.finish(joined_fits([(0, fit_table(1)), (1, fit_table(1))], 2))
    return target


def test_frames_of_steps_with_other_windows_have_their_rx_windows_side_by_side(tmp_path: Path) -> None:
    r = open_recording(stepped(tmp_path / "a.h5"))
    assert (r.sequence.rx_start, r.sequence.rx_samples) == (LONG.rx_start, 120)
    short, long = (info.step for info in r.frame_info)
    assert short is not None
    assert long is not None
    assert (short.label, long.label) == LABELS
    assert (short.tx_samples, short.rx_samples, long.rx_samples) == (20, 100, 120)
    assert np.array_equal(r.rx_volts(0), volts(1)[:, SEQUENCE.rx_start :])
    assert np.array_equal(r.frame_volts(0)[:, 10 : 10 + SEQUENCE.total], volts(1))
    assert not r.frame_volts(0)[:, :10].any()
    assert [info.valid_samples for info in r.frame_info] == [10 + SEQUENCE.total, LONG.total]


def test_it_obeys_the_rules_of_nexus_and_opens_in_xarray(tmp_path: Path) -> None:
    path = stepped(tmp_path / "a.h5")
    assert violations(path) == []
    with xr.open_dataset(path, group="step/values") as values:
        assert values["field_ut"].attrs["units"] == "uT"
        assert values["field_ut"].dims == ("frame",)
        assert values["axis"].values.tolist() == ["x", ""]
    with xr.open_dataset(path, group="step") as steps:
        assert steps["number"].values.tolist() == [1, 2]


def test_after_a_crash_the_steps_are_put_together_as_they_were(tmp_path: Path) -> None:
    stepped(tmp_path / "a.h5", finish=False)
    assert recover(tmp_path) == [tmp_path / "a.h5"]
    assert [info.step.label for info in open_recording(tmp_path / "a.h5").frame_info if info.step] == [*LABELS]


def test_a_series_outside_of_procedures_has_no_steps(tmp_path: Path) -> None:
    path = write_series(tmp_path / "a.h5")
    assert open_recording(path).frame_info[0].step is None
    with h5py.File(path) as h5:
        assert "step" not in h5


def test_a_column_of_another_length_is_damage(tmp_path: Path) -> None:
    path = stepped(tmp_path / "a.h5")
    with h5py.File(path, "a") as h5:
        del h5["step/number"]
        h5["step/number"] = np.array([1])
    with pytest.raises(RecordingError, match="/step/number"):
        open_recording(path)


def test_another_bearing_cannot_be_in_the_same_recording(tmp_path: Path) -> None:
    with SeriesWriter.create(tmp_path / "a.h5", header()) as writer, pytest.raises(InputError, match="bearing"):
        writer.go_on_with(header(variant="jewel"))


def test_fits_of_steps_under_several_windows_are_a_table_each_with_a_row_for_every_frame(tmp_path: Path) -> None:
    one, other = fit_table(1), replace(fit_table(1), name="n50", r2=np.array([0.5]))
    (d30, n50) = joined_fits([(0, one), (1, other)], 2)
    assert (d30.name, n50.name) == (one.name, "n50")
    assert d30.reason[1] == n50.reason[0] == NOT_FITTED
    assert n50.r2[1] == 0.5
    assert n50.verdict == ("refused", *other.verdict)
    assert np.isnan(d30.covariance[1]).all()
    same_window = joined_fits([(0, one), (1, replace(one, variant="dry@1"))], 2)
    assert [t.name for t in same_window] == [f"{one.name}-{one.variant}", f"{one.name}-dry-1"]
    assert [t.parameters for t in read_fits(stepped(tmp_path / "a.h5"))] == [one.parameters]
