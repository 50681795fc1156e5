"""What open_recording accepts from others, and what it says to what it cannot use."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

from drivers.errors import InputError, RecordingError
from platform_daemon.core.recordings.description import describe
from platform_daemon.core.recordings.reader import open_recording, read_calibration
from platform_daemon.core.recordings.truth import read_truth
from platform_daemon.core.schemas.base import to_json
from tests.kit.data import DATA as EXAMPLES
from tests.kit.fit_tables import read_fits
from tests.kit.recording_files import MINIMAL, P, calibration, volts, write_minimal, write_series

DATA = MINIMAL["/data"]
RESPONSE = np.ones((3, 2), complex)


def group(h5: h5py.File, name: str) -> None:
    h5.create_group(name)


def broken_link(h5: h5py.File, name: str) -> None:
    h5[name] = h5py.SoftLink("/nowhere")


def test_the_minimal_table_is_enough(tmp_path: Path) -> None:
    r = open_recording(write_minimal(tmp_path / "a.mmr"))
    assert (r.frames, r.channels, r.variant) == (2, 3, "thread")
    assert (r.sequence.rate_hz, r.sequence.rx_start, r.sequence.total) == (125e6 / 2048, 24, 124)
    assert np.array_equal(r.calibration.sensitivity, P)
    assert r.calibration.frequency_hz is None
    assert r.provenance is None
    assert r.frame_volts(1).dtype == np.float64
    assert np.array_equal(r.frame_volts(1), volts(1))
    assert np.array_equal(r.rx_volts(0), volts(0)[:, 24:])
    assert [info.verdict for info in r.frame_info] == ["good", "good"]


@pytest.mark.parametrize("name", ["example_thread.mmr.h5", "example_jewel.mmr.h5"])
def test_recordings_of_an_independent_writer_are_read(name: str) -> None:
    r = open_recording(EXAMPLES / name)
    assert r.variant in name
    assert r.rx_volts(1).shape == (3, r.sequence.rx_samples)
    assert r.calibration.sensitivity.shape == (3, 3)


@pytest.mark.parametrize(
    "changes",
    [
        {"/data": DATA.astype(np.float64)},
        {"/data": DATA.astype(">f4")},
        {"/data": DATA[:1]},
        {"/sequence/decimation": np.uint16(2048), "/sequence/numRxSamples": np.int8(100)},
        {"/sequence/decimation": 2048.0, "/sequence/baseFrequency": np.float32(125e6)},
        {"/sequence/baseFrequency": 125_000_000, "/sequence/decimation": [[2048]]},
        {"/sequence/numSwitchSamples": None, "/sequence/numTxSamples": 24},
        {"/calibration/sensitivity": P.astype(np.float32)},
        {"/resonator/variant": np.bytes_("jewel")},
        {"/resonator/variant": b"thread  "},
        {"/resonator/variant": ["thread"]},
        {"/sequence/numFrames": 77, "/sequence/more/of/it": "x", "/entry": 3, "/frames": "whatever"},
        {"/calibration/date": 20260101, "/calibration/identifier": [1, 2], "/calibration/lna_gain": "high"},
        {"/calibration/frequency": [1, 2], "/calibration/frequency_response": RESPONSE.astype(np.complex64)},
        {"/calibration/frequency": [0.0, 2.0], "/calibration/frequency_response": np.ones((3, 2), np.float32)},
        {"/simulation": broken_link},
    ],
)
def test_widths_extras_and_encodings_do_not_matter(tmp_path: Path, changes: dict) -> None:
    r = open_recording(write_minimal(tmp_path / "a.h5", changes))
    assert r.sequence.decimation == 2048
    assert r.rx_volts(0).shape == (3, 100)
    to_json(describe(r))


@pytest.mark.parametrize("names", [("r", "i"), ("real", "imag")])
def test_complex_numbers_are_read_as_other_programs_store_them(tmp_path: Path, names: tuple[str, str]) -> None:
    pairs = np.zeros((3, 2), [(name, "f8") for name in names])
    pairs[names[0]], pairs[names[1]] = 0.9, -0.2
    changes = {"/calibration/frequency": [0.0, 1e5], "/calibration/frequency_response": pairs}
    calibration = open_recording(write_minimal(tmp_path / "a.h5", changes)).calibration
    assert calibration is not None
    assert calibration.frequency_response is not None
    assert np.array_equal(calibration.frequency_response, np.full((3, 2), 0.9 - 0.2j))


@pytest.mark.parametrize("dtype", ["<i2", ">i2", "u2", "i1", "<i4", "i8", "u8"])
def test_converter_counts_are_taken_without_a_calibration_only(tmp_path: Path, dtype: str) -> None:
    counts = np.round(100.0 * DATA / np.abs(DATA).max() + (100.0 if dtype.startswith("u") else 0.0)).astype(dtype)
    bare = {"/data": counts, "/calibration/sensitivity": None}
    r = open_recording(write_minimal(tmp_path / "a.h5", bare))
    assert r.counts
    assert np.array_equal(r.frame_volts(0), counts[0])
    with pytest.raises(RecordingError, match=r"converter counts.*Remedy: convert the counts to volts"):
        open_recording(write_minimal(tmp_path / "b.h5", {"/data": counts}))
    with pytest.raises(RecordingError, match="converter counts"):
        r.with_calibration(open_recording(write_minimal(tmp_path / "c.h5")).calibration)


def test_without_window_sizes_the_whole_frame_is_rx(tmp_path: Path) -> None:
    sizes = {f"/sequence/num{w}Samples": None for w in ("Tx", "Switch", "Rx")}
    r = open_recording(write_minimal(tmp_path / "a.h5", sizes))
    assert (r.sequence.rx_start, r.sequence.rx_samples) == (0, 124)


def test_calibration_and_variant_may_be_absent(tmp_path: Path) -> None:
    r = open_recording(write_minimal(tmp_path / "a.h5", {"/calibration/sensitivity": None, "/resonator/variant": None}))
    assert r.calibration is None
    assert r.variant is None


DEFECTS = {
    "no data": ({"/data": None}, "/data"),
    "data is a group": ({"/data": group}, "/data"),
    "data is a dangling link": ({"/data": broken_link}, "/data"),
    "rank 2": ({"/data": DATA[0]}, "/data"),
    "rank 4": ({"/data": DATA[None]}, "/data"),
    "scalar": ({"/data": 1.0}, "/data"),
    "null": ({"/data": h5py.Empty("f4")}, "/data"),
    "no frames": ({"/data": DATA[:0]}, "/data"),
    "no channels": ({"/data": DATA[:, :0]}, "/data"),
    "no samples": ({"/data": DATA[:, :, :0]}, "/data"),
    "counts": ({"/data": DATA.astype(np.int16)}, "/data"),
    "complex": ({"/data": DATA.astype(complex)}, "/data"),
    "text": ({"/data": "volts"}, "/data"),
    "no clock": ({"/sequence/baseFrequency": None}, "/sequence/baseFrequency"),
    "clock 0": ({"/sequence/baseFrequency": 0.0}, "/sequence/baseFrequency"),
    "clock < 0": ({"/sequence/baseFrequency": -125e6}, "/sequence/baseFrequency"),
    "clock NaN": ({"/sequence/baseFrequency": np.nan}, "/sequence/baseFrequency"),
    "clock text": ({"/sequence/baseFrequency": "125 MHz"}, "/sequence/baseFrequency"),
    "clock group": ({"/sequence/baseFrequency": group}, "/sequence/baseFrequency"),
    "decimation 0": ({"/sequence/decimation": 0}, "/sequence/decimation"),
    "decimation missing": ({"/sequence/decimation": None}, "/sequence/decimation"),
    "decimation fraction": ({"/sequence/decimation": 2048.5}, "/sequence/decimation"),
    "decimation vector": ({"/sequence/decimation": [2048, 2048]}, "/sequence/decimation"),
    "decimation complex": ({"/sequence/decimation": 2048j}, "/sequence/decimation"),
    "decimation bool": ({"/sequence/decimation": True}, "/sequence/decimation"),
    "tx < 0": ({"/sequence/numTxSamples": -20, "/sequence/numRxSamples": 140}, "/sequence/numTxSamples"),
    "too few": ({"/sequence/numRxSamples": 99}, "/sequence"),
    "too many": ({"/sequence/numRxSamples": 101}, "/sequence"),
    "no rx": ({"/sequence/numRxSamples": 0, "/sequence/numTxSamples": 120}, "/sequence"),
    "rx absent": ({"/sequence/numRxSamples": None}, "/sequence"),
    "P shape": ({"/calibration/sensitivity": P[:, :2]}, "/calibration/sensitivity"),
    "P channels": ({"/calibration/sensitivity": P[:2]}, "/calibration/sensitivity"),
    "P transposed list": ({"/calibration/sensitivity": P.ravel()}, "/calibration/sensitivity"),
    "P NaN": ({"/calibration/sensitivity": np.where(P.max() == P, np.nan, P)}, "/calibration/sensitivity"),
    "P inf": ({"/calibration/sensitivity": np.where(P.max() == P, np.inf, P)}, "/calibration/sensitivity"),
    "P zero": ({"/calibration/sensitivity": 0 * P}, "/calibration/sensitivity"),
    "P rank 2": ({"/calibration/sensitivity": P[[0, 0, 1]]}, "/calibration/sensitivity"),
    "P text": ({"/calibration/sensitivity": "1 2 3"}, "/calibration/sensitivity"),
    "P complex": ({"/calibration/sensitivity": P * 1j}, "/calibration/sensitivity"),
    "P group": ({"/calibration/sensitivity": group}, "/calibration/sensitivity"),
    "f alone": ({"/calibration/frequency": [1.0, 2.0]}, "/calibration/frequency_response"),
    "H alone": ({"/calibration/frequency_response": RESPONSE}, "/calibration/frequency"),
    "f falls": (
        {"/calibration/frequency": [2.0, 1.0], "/calibration/frequency_response": RESPONSE},
        "/calibration/frequency",
    ),
    "f NaN": (
        {"/calibration/frequency": [1.0, np.nan], "/calibration/frequency_response": RESPONSE},
        "/calibration/frequency",
    ),
    "H short": (
        {"/calibration/frequency": [1.0, 2.0, 3.0], "/calibration/frequency_response": RESPONSE},
        "/calibration/frequency_response",
    ),
    "H NaN": (
        {"/calibration/frequency": [1.0, 2.0], "/calibration/frequency_response": RESPONSE * np.nan},
        "/calibration/frequency_response",
    ),
    "variant": ({"/resonator/variant": "watch"}, "/resonator/variant"),
    "variant number": ({"/resonator/variant": 3}, "/resonator/variant"),
    "variant bytes": ({"/resonator/variant": np.bytes_(b"\xff\xfe")}, "/resonator/variant"),
    "variants": ({"/resonator/variant": ["thread", "jewel"]}, "/resonator/variant"),
}


@pytest.mark.parametrize("defect", DEFECTS)
def test_every_defect_names_file_place_expectation_and_remedy(tmp_path: Path, defect: str) -> None:
    changes, place = DEFECTS[defect]
    path = write_minimal(tmp_path / "bad.h5", changes)
    with pytest.raises(RecordingError) as caught:
        open_recording(path)
    assert caught.value.where == f"{path}:{place}"
    assert caught.value.remedy
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["sequence", "calibration", "resonator"])
def test_a_dataset_in_place_of_a_group_is_named(tmp_path: Path, name: str) -> None:
    changes = {key: None for key in MINIMAL if key.startswith(f"/{name}/")} | {f"/{name}": 1.0}
    with pytest.raises(RecordingError, match=f"/{name}: not a group"):
        open_recording(write_minimal(tmp_path / "bad.h5", changes))


def test_data_in_another_unit_is_refused_and_volts_in_any_spelling_accepted(tmp_path: Path) -> None:
    path = write_minimal(tmp_path / "a.h5")
    for unit, accepted in (("V", True), (b"volt", True), ("mV", True), ("mA", False)):
        with h5py.File(path, "a") as h5:
            h5["data"].attrs["units"] = unit
        if accepted:
            open_recording(path)
        else:
            with pytest.raises(RecordingError, match="units 'mA'"):
                open_recording(path)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_sample_that_is_not_finite_is_named_when_its_frame_is_read(tmp_path: Path, value: float) -> None:
    data = DATA.copy()
    data[1, 2, 17] = value
    r = open_recording(write_minimal(tmp_path / "a.h5", {"/data": data}))
    r.frame_volts(0)
    with pytest.raises(RecordingError, match=r"frame 1, channel 2, sample 17"):
        r.rx_volts(1)


@pytest.mark.parametrize("k", [-1, 2])
def test_a_frame_that_does_not_exist_is_an_input_error(tmp_path: Path, k: int) -> None:
    with pytest.raises(InputError, match="0 to 1"):
        open_recording(write_minimal(tmp_path / "a.h5")).frame_volts(k)


def test_a_file_that_changed_after_opening_is_noticed(tmp_path: Path) -> None:
    r = open_recording(write_minimal(tmp_path / "a.h5"))
    write_minimal(tmp_path / "a.h5", {"/data": DATA[:, :, :50]})
    with pytest.raises(RecordingError, match="changed since"):
        r.frame_volts(0)
    r.path.unlink()
    with pytest.raises(RecordingError, match="no such file"):
        r.frame_volts(0)


def test_an_angle_recording_is_called_what_it_is(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "r.h5", "w") as h5:
        h5["time"], h5["signal"] = np.arange(5.0), np.zeros((1, 5))
    with pytest.raises(RecordingError, match="is a time series"):
        open_recording(tmp_path / "r.h5")


def test_files_that_are_no_recordings_at_all(tmp_path: Path) -> None:
    (tmp_path / "empty.h5").touch()
    (tmp_path / "text.h5").write_text("not HDF5, but long enough to have a signature somewhere\n" * 20)
    whole = write_minimal(tmp_path / "whole.h5").read_bytes()
    (tmp_path / "cut.h5").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "loop.h5").symlink_to("loop.h5")
    os.mkfifo(tmp_path / "pipe.h5")
    h5py.File(tmp_path / "bare.h5", "w").close()
    cases = {
        "empty.h5": "empty",
        "text.h5": "not an HDF5 file",
        "cut.h5": "truncated",
        "loop.h5": "cannot be opened",
        "pipe.h5": "not a regular file",
        "bare.h5": "no objects",
        "absent.h5": "no such file",
        ".": "is a directory",
        "whole.h5/x": "cannot be opened",
        "a\0b": "cannot be opened",
    }
    for name, message in cases.items():
        with pytest.raises(RecordingError, match=message):
            open_recording(tmp_path / name)


def test_a_file_without_read_permission_is_named(tmp_path: Path) -> None:
    path = write_minimal(tmp_path / "a.h5")
    path.chmod(0)
    program = (
        "import os, sys\n"
        "from platform_daemon.core.recordings.reader import open_recording\n"
        "from drivers.errors import RecordingError\n"
        "os.getuid() or os.setuid(65534)\n"
        "try: open_recording(sys.argv[1])\n"
        "except RecordingError as error: print(error)\n"
    )
    # In a process of its own, because root may read everything and must give that up first.
    done = subprocess.run([sys.executable, "-c", program, str(path)], capture_output=True, text=True, check=True)
    assert "permission" in done.stdout


def test_a_calibration_is_read_from_recordings_and_from_files_of_its_own(tmp_path: Path) -> None:
    only = {name: None for name in MINIMAL if not name.startswith("/calibration")}
    extras = {"/calibration/identifier": "cal-9", "/calibration/lna_gain": 10}
    alone = write_minimal(tmp_path / "alone.h5", only | extras)
    found = read_calibration(alone)
    assert (found.identifier, found.lna_gain, found.date) == ("cal-9", 10.0, None)
    assert np.array_equal(found.sensitivity, P)
    assert read_calibration(write_series(tmp_path / "own.h5")).identifier == "cal-7"
    with pytest.raises(RecordingError, match="calibration only"):
        open_recording(alone)
    with pytest.raises(RecordingError, match="/calibration/sensitivity: missing"):
        read_calibration(write_minimal(tmp_path / "none.h5", {"/calibration/sensitivity": None}))


def test_groups_of_ours_in_a_file_from_elsewhere_mean_nothing(tmp_path: Path) -> None:
    path = write_minimal(tmp_path / "a.h5", {"/fit/d30/values": 1, "/simulation/json": "{}"})
    assert (open_recording(path).fits, read_fits(path), read_truth(path)) == ((), (), None)


def test_another_calibration_must_have_the_same_channels(tmp_path: Path) -> None:
    r = open_recording(write_minimal(tmp_path / "a.h5"))
    assert r.with_calibration(calibration()).calibration.identifier == "cal-7"
    with pytest.raises(RecordingError, match="one row per channel"):
        r.with_calibration(calibration(sensitivity=np.vstack([P, P])))


def test_channels_of_very_different_gain_are_not_singular(tmp_path: Path) -> None:
    scaled = P * np.array([[1e-6], [1.0], [1e6]])
    found = open_recording(write_minimal(tmp_path / "a.h5", {"/calibration/sensitivity": scaled}))
    assert np.array_equal(found.calibration.sensitivity, scaled)


def test_the_reader_never_opens_the_truth(tmp_path: Path) -> None:
    path = write_series(tmp_path / "a.h5")
    assert read_truth(path)[0]["f_nat_hz"] == 214.0
    with h5py.File(path, "a") as h5:
        del h5["simulation"]
        h5["simulation"] = h5py.ExternalLink("nowhere.h5", "/x")
    r = open_recording(path)
    r.frame_volts(2)
    describe(r)


def test_no_module_but_the_writers_and_truth_itself_imports_the_truth() -> None:
    store = Path(open_recording.__code__.co_filename).parent
    importing = {p.name for p in store.glob("*.py") if "truth import" in p.read_text()}
    assert importing == {"writer.py", "assembly.py", "continuation.py"}
    naming = {p.name for p in store.glob("*.py") if "SIMULATION" in p.read_text()}
    assert naming == {"layout.py", "truth.py"}
