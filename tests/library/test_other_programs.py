"""Tables as other programs write them: a swing of one pendulum, read back from each."""

import shutil
import subprocess
import zipfile

import h5py
import numpy as np
import pandas as pd
import pytest
from scipy.io import savemat

import platform_daemon as pd_
from tests.kit.command_line import run

TIME_S = np.arange(600) / 100.0
ANGLE_RAD = 0.3 * np.exp(-0.05 * TIME_S) * np.cos(2 * np.pi * 1.3 * TIME_S)
ANGLE_DEG = np.degrees(ANGLE_RAD)
ROWS = list(zip(TIME_S.tolist(), ANGLE_DEG.tolist(), strict=True))


def lines(pattern, *heads, rows=ROWS, comma=False):
    """heads, then a row by the pattern for each sample."""
    body = [pattern.format(t, a) for t, a in rows]
    return "\n".join([*heads, *(row.replace(".", ",") for row in body)] if comma else [*heads, *body]) + "\n"


def text(name, content, encoding="utf-8", **told):
    def write(folder):
        path = folder / name
        path.write_bytes(content.encode(encoding))
        return path, told

    return write


def written(name, writer, **told):
    def write(folder):
        writer(folder / name)
        return folder / name, told

    return write


def zipped(path):
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("Angle.csv", lines("{:.9E},{:.9E},0.1", '"Time (s)","Angle (°)","Gyroscope x (rad/s)"'))
        archive.writestr("meta/device.csv", '"property","value"\n"deviceModel","phone"\n')
        archive.writestr("meta/time.csv", '"event","experiment time"\n"START",0\n')


def matlab_7_3(path):
    """HDF5 behind MATLAB's header of 512 bytes; a column vector is stored as one row, a structure as a group."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in (("time_s", TIME_S), ("run/phi_deg", ANGLE_DEG)):
            file[name] = values[None, :]
            file[name].attrs["MATLAB_class"] = np.bytes_("double")
        file["label"] = np.array([[114], [49]], dtype=np.uint16)
        file["label"].attrs["MATLAB_class"] = np.bytes_("char")
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


COLUMNS = np.column_stack([TIME_S, ANGLE_DEG])
TOLD = {"time_unit": "s", "unit": "deg"}
FILES = {
    "LibreOffice, German": text("a.csv", lines("{:.9f};{:.9f}", "t [s];phi [deg]", comma=True)),
    "Excel: byte order mark, ends of Windows": text(
        "a.csv", lines("{:.9f};{:.9f}", "sep=;", "t [s];phi [deg]").replace("\n", "\r\n"), "utf-8-sig"
    ),
    "Excel: Unicode text": text("a.txt", lines("{:.9f}\t{:.9f}", "t [s]\tphi [deg]", comma=True), "utf-16"),
    "Excel: encoding of Windows": text("a.csv", lines("{:.9f},{:.9f}", "t [s],phi [°]"), "cp1252"),
    "phyphox, comma": text("a.csv", lines("{:.9E},{:.9E}", '"Time (s)","Angle (°)"')),
    "phyphox, semicolon and decimal comma": text("a.csv", lines("{:.9E};{:.9E}", '"Time (s)";"Angle (°)"', comma=True)),
    "phyphox, archive": written("a.zip", zipped),
    "Tracker": text("a.txt", lines("{:.9E}\t{:.9E}", "mass_A", "t\tθ_{r}"), time="t", signal="θ_{r}", **TOLD),
    "Tracker, without the first samples": text(
        "a.txt", lines("{:.9E}\t{:.9E}\t", "mass_A\t\t", "t\tθ\tx"), time="t", signal="θ", **TOLD
    ),
    "an oscilloscope's line of units": text("a.csv", lines("{:.9f},{:.9f}", "Time,Channel A", "(s),(deg)", "")),
    "MATLAB, csvwrite": text("a.csv", lines("{:.10g},{:.10g}"), time="0", signal="1", **TOLD),
    "columns by blanks": text("a.dat", lines("  {:.9f}   {:.9f}", "% recorded by hand", "t_s phi_deg")),
    "columns by blanks, decimal comma": text("a.dat", lines("{:.9f} {:.9f}", "t_s phi_deg", comma=True)),
    "numpy.savetxt": written("a.txt", lambda path: np.savetxt(path, COLUMNS, header="t_s phi_deg")),
    "numpy.savetxt, comma": written(
        "a.csv", lambda path: np.savetxt(path, COLUMNS, delimiter=",", header="made by hand\nt_s,phi_deg")
    ),
    "pandas with its index": written(
        "a.csv", lambda path: pd.DataFrame({"t_s": TIME_S, "phi_deg": ANGLE_DEG, "who": "DC"}).to_csv(path)
    ),
    "pandas, time as index": written(
        "a.csv", lambda path: pd.DataFrame({"phi_deg": ANGLE_DEG}, index=pd.Index(TIME_S, name="t_s")).to_csv(path)
    ),
    "MATLAB 5": written("a.mat", lambda path: savemat(path, {"time_s": TIME_S, "phi_deg": ANGLE_DEG, "who": "DC"})),
    "MATLAB 5, a matrix": written(
        "a.mat", lambda path: savemat(path, {"data": COLUMNS}), time="data(:,1)", signal="data(:,2)", **TOLD
    ),
    "MATLAB 5, a structure": written(
        "a.mat", lambda path: savemat(path, {"run": {"t_s": TIME_S, "phi_deg": ANGLE_DEG}, "rate": 100.0})
    ),
    "MATLAB 7.3": written("a.mat", matlab_7_3),
}


@pytest.mark.parametrize("write", FILES.values(), ids=FILES)
def test_a_table_of_another_program_is_read(write, tmp_path):
    path, told = write(tmp_path)
    found = pd_.open(path, **told)
    assert (found.quantity(), found.notes) == ("angle", ())
    assert found.sampling_rate_hz() == pytest.approx(100.0, rel=1e-6)
    np.testing.assert_allclose(found.signal()[0], ANGLE_RAD, atol=2e-9)


@pytest.mark.long
@pytest.mark.parametrize("how", ["-text", "-v4", "-v6", "-v7"])
def test_what_octave_saves_is_read(how, tmp_path):
    octave = shutil.which("octave-cli")
    if octave is None:
        pytest.skip("there is no Octave")
    code = "time_s = (0:599)' / 100; phi_deg = [0.1 * cos(time_s), sin(time_s)]; n = 3; who = 'DC';"
    subprocess.run([octave, "-q", "--eval", f"{code} save('{how}', 'a.mat')"], cwd=tmp_path, check=True, timeout=60)
    found = pd_.open(tmp_path / "a.mat", signal="phi_deg(:,2)")
    np.testing.assert_allclose(found.signal()[0], np.radians(np.sin(TIME_S)), atol=1e-12)


def test_three_columns_of_a_matlab_matrix_are_the_channels_of_one_signal(tmp_path):
    dmdt = np.random.default_rng(1).standard_normal((600, 3))
    savemat(tmp_path / "a.mat", {"time_s": TIME_S, "dmdt_am2_per_s": dmdt})
    np.testing.assert_allclose(pd_.open(tmp_path / "a.mat").signal(), dmdt.T, rtol=1e-12)


SWAPPED = TIME_S.copy()
SWAPPED[[100, 101, 300, 301]] = TIME_S[[101, 100, 301, 300]]
SHUFFLED = np.random.default_rng(2).permutation(600)
RING = np.roll(np.arange(600), 250)  # as a ring buffer is read out


@pytest.mark.parametrize(
    ("time_s", "angle", "moved"),
    [
        (SWAPPED, np.interp(SWAPPED, TIME_S, ANGLE_RAD), 4),
        (TIME_S[SHUFFLED], ANGLE_RAD[SHUFFLED], None),
        (TIME_S[RING], ANGLE_RAD[RING], 600),
    ],
    ids=["two pairs", "no order at all", "two stretches exchanged"],
)
def test_samples_with_shuffled_stamps_are_sorted_and_that_is_told(time_s, angle, moved, tmp_path):
    moved = moved or np.count_nonzero(np.argsort(SHUFFLED) != np.arange(600))
    said = f"the times of {moved} samples were out of order"
    found = pd_.from_arrays(time_s, angle_rad=angle)
    np.testing.assert_allclose(found.signal()[0], ANGLE_RAD, atol=1e-12)
    assert said in found.notes[0]
    np.savetxt(tmp_path / "a.txt", np.column_stack([time_s, angle]), header="t_s u_v")
    volts = pd_.open(tmp_path / "a.txt")
    np.testing.assert_allclose(volts.signal()[0], ANGLE_RAD, atol=1e-12)
    assert any(said in note for note in volts.notes)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["time"], file["signal"] = time_s, angle[None]
    assert said in pd_.open(tmp_path / "a.h5").notes[0]


def test_a_command_tells_that_samples_were_sorted(tmp_path):
    np.savetxt(tmp_path / "a.txt", np.column_stack([SWAPPED, ANGLE_RAD]), header="t_s u_v")
    assert "samples were sorted by time" in run("info", tmp_path / "a.txt").stderr


@pytest.mark.parametrize(
    "time_s",
    [
        TIME_S[::-1],
        np.concatenate([TIME_S[570:] + 0.1, TIME_S[:570]]),
        np.concatenate([TIME_S[:300], TIME_S[:300] + 0.005]),
    ],
    ids=["counts down", "another run first", "begins again"],
)
def test_a_clock_that_runs_back_is_not_sorted(time_s):
    with pytest.raises(pd_.InputError, match="runs back"):
        pd_.from_arrays(time_s, angle_rad=ANGLE_RAD)


def two_tables(path):
    with zipfile.ZipFile(path, "w") as archive:
        for name in ("Gyroscope.csv", "Raw Data.csv"):
            archive.writestr(name, "t_s,phi_deg\n0,1\n1,2\n")


@pytest.mark.parametrize(
    ("write", "says"),
    [
        (text("a.csv", lines("{:.9f},{:.9f}", "t [s],omega [rad/s]")), r"'omega \[rad/s\]' is in 'rad/s'"),
        (text("a.txt", lines("{:.9E}\t{:.9E}", "mass_A", "t\tθ")), "unit of the column 't' is not known"),
        (text("a.csv", lines("{:.9f},{:.9f}", "t_s,t_s")), "two columns are called 't_s'"),
        (text("a.csv", lines("{:.9f},{:.9f}", "t_s,phi_deg") + "6.0,none\n"), "'none' in line 602"),
        (text("a.csv", lines("{:.9f},{:.9f}", "t_s,phi_deg") + "6.0,\n6.01,1\n"), "no finite numbers"),
        (text("a.csv", lines("{:.9f},{:.9f}", "t_s,phi_deg") + "6.0,1,1\n"), "line 602 has 3, the others 2"),
        (text("a.mat", "no file of MATLAB"), "MATLAB"),
        (written("a.mat", lambda path: savemat(path, {"who": "DC", "rate": 3.0})), "no array of numbers"),
        (written("a.mat", lambda path: savemat(path, {"t_s": TIME_S, "phi_deg": np.ones((7, 2))})), "shape"),
        (written("a.zip", two_tables), "Gyroscope.csv, Raw Data.csv"),
        (text("a.zip", "no archive"), "cannot be read as zip"),
        (text("a.xlsx", "PK"), "save the sheet as CSV"),
        (text("a.trk", "<object/>"), "Export"),
        (text("a.txt", "# Created by Octave\n# name: t_s\n# type: matrix\n# rows: 2\n 1\n"), "'t_s' cannot be read"),
    ],
)
def test_what_cannot_be_read_is_one_error_with_a_remedy(write, says, tmp_path):
    path, told = write(tmp_path)
    with pytest.raises(pd_.InputError, match=says) as found:
        pd_.open(path, **told)
    assert str(path) in found.value.where
    assert found.value.remedy
    assert "\n" not in str(found.value)


def test_a_column_of_a_matrix_that_is_not_there_is_named_with_what_there_is(tmp_path):
    savemat(tmp_path / "a.mat", {"t_s": TIME_S, "data": COLUMNS})
    with pytest.raises(pd_.RecordingError, match=r"no column 'data\(:,3\)'") as found:
        pd_.open(tmp_path / "a.mat", signal="data(:,3)", unit="deg")
    assert "data (600 x 2)" in found.value.remedy
