"""Our files open in xarray as they are: every dimension has a name, every number a unit, nothing is left out."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest
import xarray as xr
from httpx2 import Response
from starlette.testclient import TestClient

from drivers.calibration import ReceiveCalibration
from platform_daemon import __version__
from platform_daemon.core.recordings.data_folder import open_data_folder
from platform_daemon.core.recordings.description import describe
from platform_daemon.core.recordings.header import FitTable
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.series_writer import SeriesWriter
from platform_daemon.core.recordings.truth import read_truth
from platform_daemon.core.settings import load_platform
from platform_daemon.core.web.server import create_api
from platform_daemon.processes.assembly import start_engine
from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.fit_tables import read_fits
from tests.kit.linked_api import linked_context
from tests.kit.recording_files import (
    SEQUENCE,
    calibration,
    fit_table,
    header,
    shot,
    volts,
    write_minimal,
    write_series,
)

FOUR_ROWS = np.vstack([np.eye(3), np.ones(3)]) * 1e-3


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Iterator[SimpleNamespace]:
    """A daemon that calibrated its simulated platform and recorded one blank and two excited shots; and the file."""
    folder = open_data_folder(tmp_path_factory.mktemp("data"))
    engine = start_engine(load_platform("simulated"))
    try:
        with TestClient(create_api(linked_context(engine, folder)), base_url="http://127.0.0.1") as client:
            for kind in ("receive", "transmit"):
                body = {"kind": kind, "name": kind, "frequencies_hz": [212.0, 424.0], "repetitions": 2}
                made = result_of(client, client.post("/calibrations", json=body))["calibration"]
                assert client.post("/calibrations/adopt", json={"kind": kind, "calibration": made}).status_code == 200
            body = {**SHORT_JEWEL, "shots": 2, "blank_shots": 1}
            identifier = result_of(client, client.post("/acquisitions", json=body))["recording"]
            path = folder.recordings / f"{identifier}.h5"
            yield SimpleNamespace(path=path, folder=folder, client=client)
    finally:
        engine.close()


def result_of(client: TestClient, accepted: Response) -> dict[str, Any]:
    deadline = time.monotonic() + 120
    while (job := client.get(accepted.headers["location"]).json())["state"] in ("queued", "running"):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    assert job["state"] == "done"
    return dict(job["result"])


@pytest.fixture(params=["h5netcdf", "netcdf4"])
def engine(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def download(measured: SimpleNamespace, tmp_path: Path) -> Callable[..., Path]:
    """Loads dm/dt of a frame as a file."""

    def load(identifier: str, frame: int, **query: float) -> Path:
        query_all = {"format": "h5", **query}
        answer = measured.client.get(f"/recordings/{identifier}/frames/{frame}/dmdt", params=query_all)
        assert answer.status_code == 200
        (tmp_path / "dmdt.h5").write_bytes(answer.content)
        return tmp_path / "dmdt.h5"

    return load


def opened(path: Path, group: str, engine: str) -> xr.Dataset:
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # a dimension twice, a scale in doubt: both readers only warn
        return xr.load_dataset(path, group=group, engine=engine)


def complaints(path: Path, engine: str) -> list[str]:
    """What a user of xarray would miss in a file, in all its groups."""
    with h5py.File(path) as h5:
        groups = {"/": h5}
        h5.visititems(lambda name, item: groups.update({f"/{name}": item}))
        inside = {
            name: {key for key, item in group.items() if isinstance(item, h5py.Dataset)}
            for name, group in groups.items()
            if isinstance(group, h5py.Group)
        }
    found = []
    for group, names in inside.items():
        dataset = opened(path, group, engine)
        found += [f"{group}: dimension {name}" for name in map(str, dataset.dims) if name.startswith("phony")]
        found += [f"{group}: {name} is left out" for name in names - set(map(str, dataset.variables))]
        numbers = (name for name, item in dataset.variables.items() if item.dtype.kind in "iufcV")
        found += [
            f"{group.rstrip('/')}/{name} has no units" for name in numbers if not dataset[name].attrs.get("units")
        ]
    return found


def test_a_measured_recording_with_fits_and_a_blank_shot(measured: SimpleNamespace, engine: str) -> None:
    everything = {"calibration/p_std", "calibration/transmit", "excitation", "fit/d30", "simulation/values"}
    with h5py.File(measured.path) as h5:
        assert [name for name in everything if name not in h5] == []
    assert complaints(measured.path, engine) == []


def test_the_calibration_files_it_was_made_with(measured: SimpleNamespace, engine: str) -> None:
    made = sorted(measured.folder.calibrations.glob("*.h5"))
    assert [path.name.partition("@")[0] for path in made] == ["receive", "transmit"]
    assert [complaints(path, engine) for path in made] == [[], []]


@pytest.mark.long
def test_other_numbers_of_channels_names_and_parameters(tmp_path: Path, engine: str) -> None:
    for channels, sensitivity in ((1, None), (2, None), (4, FOUR_ROWS)):
        found = None if sensitivity is None else ReceiveCalibration(sensitivity, "four", "2026-02-28")
        said = header(channels=channels, calibration=found, channel_names=(), devices={}, excitation=None)
        path = tmp_path / f"{channels}.h5"
        with SeriesWriter.create(path, said) as writer:
            for k in (1, 2):
                writer.add_shot(shot(k, volts=volts(k, channels)))
            writer.finish((without_parameters(2),))
        assert complaints(path, engine) == []
        assert opened(path, "/", engine)["data"].shape == (2, channels, SEQUENCE.total)


def without_parameters(frames: int) -> FitTable:
    """As on-line fits leave it if none was good."""
    nothing = np.full(frames, np.nan)
    tables = np.zeros((frames, 0)), np.zeros((frames, 0)), np.zeros((frames, 0, 0))
    verdicts = ("refused",) * frames, ("no signal",) * frames
    return FitTable("n50", (), *tables, nothing, nothing, nothing, nothing, *verdicts)


@pytest.mark.long
def test_the_checker_sees_what_it_is_there_for(tmp_path: Path, engine: str) -> None:
    path = write_minimal(tmp_path / "others.h5")
    with pytest.warns(UserWarning, match="phony") if engine == "h5netcdf" else warnings.catch_warnings():
        dataset = xr.load_dataset(path, engine=engine)
    assert all(str(name).startswith("phony") for name in dataset.dims)
    assert "units" not in dataset["data"].attrs
    ours = write_series(tmp_path / "ours.h5")
    with h5py.File(ours, "r+") as h5:
        del h5["frames/monotonic"].attrs["units"]
    assert complaints(ours, engine) == ["/frames/monotonic has no units"]


def test_volts_are_found_by_frame_channel_name_and_second(measured: SimpleNamespace, engine: str) -> None:
    root = opened(measured.path, "/", engine)
    assert root["data"].dims == ("frame", "channel", "time")
    assert root["channel_names"].dims == ("channel",)
    assert set(root.coords) == {"frame", "channel", "time", "channel_names"}
    received = root["data"].sel(frame=1).where(root["channel_names"] == "y", drop=True).sel(time=slice(0.0, None))
    np.testing.assert_array_equal(received.values[0], open_recording(measured.path).rx_volts(1)[1])


def test_a_fit_is_found_by_parameter_and_says_its_unit(measured: SimpleNamespace, engine: str) -> None:
    table = opened(measured.path, "fit/d30", engine)
    (stored,) = read_fits(measured.path)
    k = stored.parameters.index("m_r_am2")
    moment = table["values"].sel(parameters="m_r_am2")
    assert moment["parameter_units"] == "A m^2"
    np.testing.assert_array_equal(moment, stored.values[:, k])
    np.testing.assert_array_equal(moment["frame"], [0, 1, 2])
    assert np.isnan(moment.sel(frame=0))
    square = table["covariance"].sel(parameters="m_r_am2", parameters_2="f_nat_hz")
    np.testing.assert_array_equal(square, stored.covariance[:, k, stored.parameters.index("f_nat_hz")])


def test_the_whole_file_is_one_tree(measured: SimpleNamespace, engine: str) -> None:
    # Names mean the same at every level: else xarray refuses the tree.
    with xr.open_datatree(measured.path, engine=engine) as tree:
        assert tree["calibration/transmit/field_per_volt"].dims == ("coil", "world_axis", "transmit_frequency")
        assert tree["calibration/p_std"].dims == ("channel", "world_axis", "frequency")
        assert tree["frames/temperature"].sizes == {"frame": 3}


def test_a_complex_response_comes_as_complex_numbers(tmp_path: Path) -> None:
    path = write_series(tmp_path / "a.h5")
    expected = calibration().frequency_response
    plain = xr.load_dataset(path, group="calibration", engine="h5netcdf")["frequency_response"]
    asked = xr.load_dataset(path, group="calibration", engine="netcdf4", auto_complex=True)["frequency_response"]
    assert plain.dims == asked.dims == ("channel", "frequency")
    np.testing.assert_array_equal(plain, expected)
    np.testing.assert_array_equal(asked, expected)


def test_dmdt_names_channels_time_and_source(
    measured: SimpleNamespace, download: Callable[..., Path], engine: str
) -> None:
    path = download(measured.path.stem, 1, start_s=0.1, stop_s=0.2)
    assert complaints(path, engine) == []
    file, recording = opened(path, "/", engine), open_recording(measured.path)
    assert file["dmdt"].dims == ("channel", "time")
    assert file["dmdt"].attrs["units"] == "A m^2/s"
    assert file["channel"].values.tolist() == ["x", "y", "z"]
    assert file["time"].values[0] == pytest.approx(0.1, abs=1e-5)
    assert np.diff(file["time"]) == pytest.approx(1 / file.attrs["sampling_rate_hz"])
    assert recording.provenance is not None
    assert recording.calibration is not None
    source = {
        "recording": measured.path.stem,
        "file": measured.path.name,
        "frame": 1,
        "shot": 2,
        "time_stamp": recording.frame_info[1].time_stamp,
        "series_id": recording.provenance.series_id,
        "calibration": recording.calibration.identifier,
        "creator_version": __version__,
    }
    assert {name: file.attrs[name] for name in source} == source


def test_volts_of_a_recording_that_says_little(
    measured: SimpleNamespace, download: Callable[..., Path], engine: str
) -> None:
    name = f"others-{engine}"  # one each: the index may still be reading that of the engine before
    write_minimal(measured.folder.recordings / f"{name}.h5", {"/calibration/sensitivity": None})
    path = download(name, 0)
    assert complaints(path, engine) == []
    file = opened(path, "/", engine)
    assert file["voltage"].attrs["units"] == "V"
    assert file["channel"].values.tolist() == ["0", "1", "2"]
    assert "no calibration" in file.attrs["notes"]
    assert "series_id" not in file.attrs


def test_a_truth_that_names_its_numbers_like_scales(tmp_path: Path, engine: str) -> None:
    truth = {"frame": 7, "time": 8.5, "axis": 9, "values": {"frame": 1}}
    with SeriesWriter.create(tmp_path / "a.h5", header()) as writer:
        for k in (1, 2):
            writer.add_shot(shot(k, truth=truth))
        writer.finish()
    assert read_truth(tmp_path / "a.h5") == [truth, truth]
    assert complaints(tmp_path / "a.h5", engine) == []


def test_a_file_without_scales_reads_as_before(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    new = write_series(tmp_path / "new.h5", fits=(fit_table(3),))
    monkeypatch.setattr("platform_daemon.core.recordings.assembly.add_dimension_scales", lambda *_, **__: None)
    old = write_series(tmp_path / "old.h5", fits=(fit_table(3),))
    with h5py.File(old, "r+") as h5:
        assert "frame" not in h5
        del h5["fit/d30/parameter_units"]
    for read in (lambda path: describe(open_recording(path)).shots, lambda path: repr(read_fits(path))):
        assert read(old) == read(new)
    np.testing.assert_array_equal(open_recording(old).frame_volts(2), open_recording(new).frame_volts(2))
