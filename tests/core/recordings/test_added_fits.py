"""Fits that are stored in a recording after it was finished, and tables of earlier versions."""

from dataclasses import replace

import h5py
import numpy as np
import pytest
import xarray as xr

from drivers.errors import InputError
from platform_daemon.core.recordings.added_fits import add_fit
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recorded_fits import read_fit
from tests.kit.fit_tables import read_fits
from tests.kit.recording_files import fit_table, write_series


def test_further_fits_stand_next_to_those_of_the_series(tmp_path):
    path = write_series(tmp_path / "a.h5", fits=(fit_table(3),))
    volts = open_recording(path).rx_volts(1)
    added = replace(fit_table(3), name="n50_characterise")
    add_fit(path, added)
    assert [table.name for table in read_fits(path)] == ["d30", "n50_characterise"]
    found = read_fit(open_recording(path), "n50_characterise")
    assert np.array_equal(found.covariance, added.covariance, equal_nan=True)
    assert np.array_equal(open_recording(path).rx_volts(1), volts)
    assert [each.name for each in tmp_path.iterdir()] == ["a.h5"]


def test_their_covariance_is_read_by_the_names_of_its_rows_in_xarray(tmp_path):
    path = write_series(tmp_path / "a.h5", fits=(fit_table(3),))
    added = replace(fit_table(3), name="n50_characterise")
    add_fit(path, added)
    with xr.open_dataset(path, group="fit/n50_characterise", engine="h5netcdf") as fits:
        found = fits["covariance"].sel(frame=0, parameters="f_nat_hz", parameters_2="m_r_am2")
        assert float(found) == added.covariance[0, 0, 1]


def test_a_name_that_is_taken_and_a_table_of_other_frames_are_refused(tmp_path):
    path = write_series(tmp_path / "a.h5", fits=(fit_table(3),))
    before = path.read_bytes()
    with pytest.raises(InputError, match="already"):
        add_fit(path, fit_table(3))
    with pytest.raises(InputError, match="shape"):
        add_fit(path, replace(fit_table(2), name="other"))
    assert path.read_bytes() == before


def test_a_table_without_a_covariance_still_opens(tmp_path):
    path = write_series(tmp_path / "a.h5", fits=(fit_table(3),))
    with h5py.File(path, "r+") as file:
        del file["fit/d30/covariance"]
    found = read_fit(open_recording(path), "d30")
    assert np.isnan(found.covariance).all()
    assert found.covariance.shape == (3, 2, 2)
    assert np.isfinite(found.values).any()
