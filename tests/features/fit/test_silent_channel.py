"""A channel that nothing was read from is told, and not taken for a measured zero in silence."""

from __future__ import annotations

import shutil

import h5py
import pytest

from platform_daemon.features.fit.fit import fit_measurement
from platform_daemon.features.fit.fit_request import FitSettings
from platform_daemon.features.fit.measurement import open_for_fit
from tests.kit.data import DATA


@pytest.mark.parametrize("value", [0.0, 0.125])
def test_a_channel_of_one_value_is_warned_of(tmp_path, value):
    path = tmp_path / "a.h5"
    shutil.copy(DATA / "example_jewel.mmr.h5", path)
    with h5py.File(path, "a") as h5:
        volts = h5["data"][...]
        volts[:, 2] = value
        h5["data"][...] = volts
    measurement, ask = open_for_fit(path, FitSettings(window=0.1))
    (frame,) = fit_measurement(measurement, ask, [0]).frames
    (said,) = [text for text in frame.warnings if text.startswith("silent_channel")]
    assert f"every sample of channel 2 is {value:.6g} V, without any noise" in said
