"""Units of numbers in files: which convert, and what the readers make of them."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from drivers.errors import RecordingError
from platform_daemon.core.recordings.angle_series import read_angles
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.unit_conversion import conversion
from platform_daemon.core.state.errors import UnknownUnit
from tests.kit.recording_files import P, volts, write_minimal, write_series


@pytest.mark.parametrize(
    ("found", "wanted", "factor"),
    [
        ("ms", "s", 1e-3),
        ("min", "s", 60.0),
        ("Milliseconds", "s", 1e-3),
        ("kHz", "Hz", 1e3),
        ("MHz", "Hz", 1e6),
        ("s-1", "Hz", 1.0),
        ("mT/A", "T/A", 1e-3),
        ("nT/mA", "T/A", 1e-6),
        ("V/(A m²/s)", "T/A", 1.0),
        ("mA.m2.s-1", "A m^2/s", 1e-3),
        ("µT", "T", 1e-6),
        ("Volts", "V", 1.0),
        ("deg", "rad", np.pi / 180),
        ("1", "rad", 1.0),
        ("%", "1", 1e-2),
    ],
)
def test_multiples_convert(found: str, wanted: str, factor: float) -> None:
    assert conversion(found, wanted) == (pytest.approx(factor, rel=1e-15), 0.0)


@pytest.mark.parametrize(
    ("found", "wanted"),
    [
        ("furlong", "s"),
        ("V", "s"),
        ("rad/s", "Hz"),
        ("mhz", "Hz"),
        ("V/", "V"),
        ("(V", "V"),
        ("V)", "V"),
        ("counts", "V"),
        ("V" * 1000, "V"),
        ("10**10**10", "V"),
    ],
)
def test_what_is_no_multiple_is_refused(found: str, wanted: str) -> None:
    assert conversion(found, wanted) is None


def test_kelvin_is_converted_with_its_offset() -> None:
    found = conversion("K", "degC")
    assert found is not None
    assert found.factor * 294.65 + found.offset == pytest.approx(21.5)


def in_unit(path: Path, name: str, factor: float, unit: object) -> Path:
    with h5py.File(path, "a") as h5:
        h5[name][...] = h5[name][()] * factor
        h5[name].attrs["units"] = unit
    return path


@pytest.mark.parametrize(
    ("name", "factor", "unit"),
    [
        ("/sequence/baseFrequency", 1e-6, "MHz"),
        ("/sequence/baseFrequency", 1e-6, np.bytes_("MHz")),
        ("/sequence/baseFrequency", 1e-6, ["MHz"]),
        ("/calibration/sensitivity", 1e3, "mT/A"),
        ("/data", 1e3, "mV"),
    ],
)
def test_a_recording_in_multiples_of_its_units_is_the_same_recording(
    tmp_path: Path, name: str, factor: float, unit: object
) -> None:
    """Case 02: the units of every number that has a dimension count."""
    plain = open_recording(write_minimal(tmp_path / "plain.h5"))
    found = open_recording(in_unit(write_minimal(tmp_path / "scaled.h5"), name, factor, unit))
    assert found.sequence == plain.sequence
    assert found.calibration.sensitivity == pytest.approx(P, rel=1e-12)
    assert found.frame_volts(1) == pytest.approx(plain.frame_volts(1), rel=1e-6)


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("/sequence/baseFrequency", "furlong"),
        ("/sequence/numRxSamples", "s"),
        ("/calibration/sensitivity", "V"),
        ("/data", "mA"),
    ],
)
def test_an_unknown_unit_is_refused_by_name(tmp_path: Path, name: str, unit: str) -> None:
    path = in_unit(write_minimal(tmp_path / "a.h5"), name, 1, unit)
    with pytest.raises(UnknownUnit, match=f"{name}: has units '{unit}'.*Remedy: convert"):
        open_recording(path)


def test_columns_of_our_own_files_are_converted_too(tmp_path: Path) -> None:
    path = write_series(tmp_path / "a.h5", count=2)
    before = open_recording(path).frame_info[1]
    for name, factor, unit in (
        ("/frames/monotonic", 1e3, "ms"),
        ("/excitation/field", 1e6, "uT"),
        ("/excitation/phase", 180 / np.pi, "deg"),
        ("/excitation/current", 1e3, "mA"),
    ):
        in_unit(path, name, factor, unit)
    with h5py.File(path, "a") as h5:
        h5["/frames/temperature"][...] += 273.15
        h5["/frames/temperature"].attrs["units"] = "K"
    after = open_recording(path).frame_info[1]
    assert (after.monotonic_s, after.temperature_c) == pytest.approx((before.monotonic_s, before.temperature_c))
    assert after.excitation.field_t == pytest.approx(before.excitation.field_t)
    assert after.excitation.phase_rad == pytest.approx(before.excitation.phase_rad)
    assert after.excitation.current_a == pytest.approx(before.excitation.current_a)


def test_a_side_table_in_an_unknown_unit_is_no_absent_one(tmp_path: Path) -> None:
    path = write_minimal(tmp_path / "a.h5", {"/calibration/temperature": 21.0})
    with h5py.File(path, "a") as h5:
        h5["/calibration/temperature"].attrs["units"] = "bar"
    with pytest.raises(UnknownUnit, match="'bar'"):
        open_recording(path)


def test_packed_volts_are_unpacked_and_their_missing_samples_are_missed(tmp_path: Path) -> None:
    scale = 20 / 65536
    packed = np.round(np.stack([volts(0), volts(1)]) / scale).astype(np.int16)
    packed[1, 2, 5] = -32768
    path = write_minimal(tmp_path / "a.h5", {"/data": packed})
    with h5py.File(path, "a") as h5:
        h5["data"].attrs.update({"scale_factor": 1e3 * scale, "units": "mV", "_FillValue": np.int16(-32768)})
    r = open_recording(path)
    assert not r.counts
    assert r.frame_volts(0) == pytest.approx(volts(0), rel=1e-6)
    with pytest.raises(RecordingError, match=r"frame 1, channel 2, sample 5.*not_finite"):
        r.frame_volts(1)
    with h5py.File(path, "a") as h5:
        h5["data"].attrs["scale_factor"] = 0.0
    with pytest.raises(RecordingError, match="scale_factor"):
        r.frame_volts(0)


@pytest.mark.parametrize("unit", ["s", "ms", "min", "milliseconds since 2026-01-01"])
def test_the_time_of_an_angle_may_be_in_any_unit_of_time(tmp_path: Path, unit: str) -> None:
    factor = {"s": 1.0, "min": 60.0}.get(unit, 1e-3)
    with h5py.File(tmp_path / "a.h5", "w") as h5:
        h5["time"], h5["signal"] = np.arange(200) * 0.01 / factor, np.sin(np.arange(200.0))[None]
        h5["time"].attrs["units"] = unit
    assert read_angles(tmp_path / "a.h5").sampling_rate_hz == pytest.approx(100.0)


def test_nanoseconds_since_1970_keep_their_even_steps(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as h5:
        h5["time"] = np.int64(1_790_000_000_000_000_000) + np.arange(200, dtype=np.int64) * 10_000
        h5["signal"] = np.sin(np.arange(200.0))[None]
        h5["time"].attrs["units"] = "nanoseconds since 1970-01-01"
    series = read_angles(tmp_path / "a.h5")
    assert series.sampling_rate_hz == pytest.approx(1e5)
    assert series.clock == ()


@pytest.mark.parametrize("names", [("real", "imag"), ("Re", "Im"), ("imag", "real")])
def test_complex_numbers_may_be_compounds_of_two_floats(tmp_path: Path, names: tuple[str, str]) -> None:
    """Case 11: as Octave and others write them."""
    table = np.zeros((3, 2), dtype=[(name, "f8") for name in names])
    for name in names:
        table[name] = 0.25 if name.lower().startswith("im") else 1.0
    changes = {"/calibration/frequency": [0.0, 1e5], "/calibration/frequency_response": table}
    found = open_recording(write_minimal(tmp_path / "a.h5", changes)).calibration.frequency_response
    assert np.all(found == 1 + 0.25j)


@pytest.mark.parametrize("axes", [(2, 1, 0), (0, 2, 1), (2, 0, 1)])
@pytest.mark.parametrize("named", [True, False])
def test_reversed_axes_are_refused_at_opening(tmp_path: Path, axes: tuple[int, ...], named: bool) -> None:
    """Case 08."""
    data = np.stack([volts(0), volts(1)]).transpose(axes)
    windows = {} if named else {f"/sequence/num{w}Samples": None for w in ("Tx", "Switch", "Rx")}
    path = write_minimal(tmp_path / "a.h5", {"/data": data, "/calibration/sensitivity": None, **windows})
    with pytest.raises(RecordingError, match=r"axes look reversed.*Remedy: transpose"):
        open_recording(path)


def test_more_frames_than_samples_are_read_where_the_windows_say_so(tmp_path: Path) -> None:
    changes = {"/data": np.ones((50, 3, 20)), "/calibration/sensitivity": None}
    sizes = {"/sequence/numTxSamples": None, "/sequence/numSwitchSamples": None, "/sequence/numRxSamples": 20}
    assert open_recording(write_minimal(tmp_path / "a.h5", changes | sizes)).frames == 50
