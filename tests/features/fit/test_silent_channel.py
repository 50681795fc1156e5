"""A channel that nothing was read from is told, and not taken for a measured zero in silence."""

from __future__ import annotations

import shutil

import h5py
import pytest

from platform_daemon.features.fit.fit import fit_measurement
from platform_daemon.features.fit.fit_request import FitSettings
from platform_daemon.features.fit.measurement import open_for_fit
from tests.kit.data import DATA


def fitted(path, change):
    """The fit of the first frame of an example, whose volts (frames, channels, samples) `change` has changed."""
    shutil.copy(DATA / "example_jewel.mmr.h5", path)
    with h5py.File(path, "a") as h5:
        volts = h5["data"][...]
        change(volts)
        h5["data"][...] = volts
    measurement, ask = open_for_fit(path, FitSettings(window=0.1))
    (frame,) = fit_measurement(measurement, ask, [0]).frames
    return frame


def set_to(value, *place):
    def change(volts):
        volts[place] = value

    return change


@pytest.mark.parametrize("value", [0.0, 0.125])
def test_a_channel_of_one_value_is_warned_of(tmp_path, value):
    frame = fitted(tmp_path / "a.h5", set_to(value, slice(None), 2))
    (said,) = [text for text in frame.warnings if text.startswith("silent_channel")]
    assert f"every sample of channel 2 is {value:.6g} V, without any noise" in said


def test_a_frame_that_was_never_written_is_refused_as_such(tmp_path):
    frame = fitted(tmp_path / "a.h5", set_to(0.0, 0))
    assert frame.verdict == "refused"
    assert "every sample of every channel is 0 V: nothing was recorded" in frame.reason
    assert "drive" not in frame.reason


def test_a_recording_that_ended_early_is_warned_of(tmp_path):
    frame = fitted(tmp_path / "a.h5", set_to(0.0, 0, slice(None), slice(-3000, None)))
    (said,) = [text for text in frame.warnings if text.startswith("stopped")]
    assert "the last 3000 of" in said
