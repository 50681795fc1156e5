"""Tables of other programs that are nearly right: each is read, or refused in one line that says what is wrong."""

import zipfile

import h5py
import numpy as np
import pytest
from scipy.io import savemat

import platform_daemon as pd_
from platform_daemon.core.recordings.text_table import text_table
from platform_daemon.core.recordings.unit_conversion import conversion
from tests.kit.command_line import run

TIME_S = np.arange(600) / 100.0
ANGLE_DEG = 17.0 * np.exp(-0.05 * TIME_S) * np.cos(2 * np.pi * 1.3 * TIME_S)
ANGLE_RAD = np.radians(ANGLE_DEG)


def rows(pattern, *heads):
    """heads, then a row for each sample by the pattern, in which t is the time, a the angle and k the number."""
    body = [pattern.format(t=t, a=a, k=k) for k, (t, a) in enumerate(zip(TIME_S, ANGLE_DEG, strict=True))]
    return "\n".join([*heads, *body]) + "\n"


def table(folder, content, name="a.csv", toml=""):
    path = folder / name
    path.write_text(content, encoding="utf-8")
    if toml:
        path.with_name(f"{name}.toml").write_text(toml, encoding="utf-8")
    return path


def refused(path, *says):
    """It is, in one line with all of these."""
    with pytest.raises(pd_.InputError) as found:
        pd_.open(path)
    said = str(found.value)
    assert "\n" not in said
    assert found.value.remedy
    for each in says:
        assert each in said
    return said


def is_read(path):
    found = pd_.open(path)
    assert (found.quantity(), found.notes) == ("angle", ())
    assert found.sampling_rate_hz() == pytest.approx(100.0, rel=1e-6)
    np.testing.assert_allclose(found.signal()[0], ANGLE_RAD, atol=1e-7)


def test_of_an_angle_whose_time_has_holes_the_longest_stretch_is_read(tmp_path):
    lines = rows("{t:.3f},{a:.6f}", "time_s,phi_deg").splitlines(keepends=True)
    found = pd_.open(table(tmp_path, "".join(lines[:101] + lines[140:])))
    np.testing.assert_allclose(found.signal()[0], ANGLE_RAD[139:], atol=1e-7)
    assert "only samples 100 to 560, the longest even stretch, are used" in found.notes[0]


TA = "{t:.3f},{a:.6f}"
READ = {
    "per cent beside it": rows(TA + ",98", "time_s,phi (deg),battery (%)"),
    "counts beside it": rows(TA + ",7", "time_s,phi_deg,trigger (counts)"),
    "a temperature before time": rows("20.5," + TA, "T (°C),time_s,phi_deg"),
    "a degree sign behind each": rows("{t:.3f},{a:.6f}°", "time_s,phi"),
    "No.": rows("{k},{t:.3f},{a:.6f}", "No.,t [s],phi [deg]"),
    "n": rows("{k},{t:.3f},{a:.6f}", "n,t_s,phi_deg"),
    "Index": rows("{k},{t:.3f},{a:.6f}", "Index,t_s,phi_deg"),
    "a hash": rows("{k},{t:.3f},{a:.6f}", "#,t_s,phi_deg"),
    "a line of units": rows(TA, "time,phi", "s,deg"),
    "keys and values first": rows(TA, "Sample rate (Hz),100", "Operator,Smith", "time_s,phi_deg"),
    "names with phi in them": rows("{t:.3f},{a:.6f},ab", "time_s,phi_deg,graphics"),
    "an empty column beside it": rows("{t:.3f},{a:.6f},", "time_s,phi_deg,remark"),
    "two columns of text of one name": rows("{t:.3f},{a:.6f},ab,cd", "time_s,phi_deg,note,note"),
    "a column of text beside it": rows("{t:.3f},{a:.6f},12:00:{k}", "time_s,phi_deg,clock"),
    "several texts beside it": rows("{t:.3f},{a:.6f},a,b,c", "time_s,phi_deg,p,q,r"),
}


@pytest.mark.parametrize("content", READ.values(), ids=READ)
def test_what_stands_beside_time_and_angle_is_left_out(content, tmp_path):
    is_read(table(tmp_path, content))


def test_a_decimal_comma_is_judged_from_the_whole_text(tmp_path):
    whole = [f"{1e3 * t:.0f};{a:.4f}".replace(".", ",") for t, a in zip(TIME_S, ANGLE_DEG, strict=True)]
    last = [f"{6000 + 10 * k};0" for k in range(40)]
    found = pd_.open(table(tmp_path, "\n".join(["time_ms;phi_deg", *whole, *last]) + "\n"))
    np.testing.assert_allclose(found.signal()[0][:600], ANGLE_RAD, atol=1e-5)


REFUSED = {
    "counts": (rows(TA, "time_s,ADC (counts)"), ["'ADC (counts)' is in 'counts'", "of an angle rad or deg"]),
    "per cent": (rows(TA, "time_s,position (%)"), ["is in '%'", "of an angle rad or deg"]),
    "Grad": (rows(TA, "t [s],Winkel [Grad]"), ["is in 'Grad'", "`Winkel [UNIT]`"]),
    "two angles": (
        rows(TA + ",1", "time_s,phi_deg,theta_deg"),
        ["2 columns are angles: 'phi_deg', 'theta_deg'", 'the line signal = ["phi_deg"] in a.csv.toml'],
    ),
    "clock times": (
        rows("12:00:{k:06.3f},{a:.6f}", "Time,phi_deg"),
        ["'Time'", "holds text, '12:00:00.000' in line 2", "time = 'NAME'"],
    ),
    "an angle of text": (
        rows("{t:.3f},{a:.6f} left", "time_s,phi_deg"),
        ["'phi_deg'", "holds text", "left' in line 2"],
    ),
    "a text that is told": (rows(TA + ",up", "time_s,phi_deg,way"), ["'way' holds", "holds text, 'up' in line 2"]),
    "missing cells": (rows(TA, "time_s,phi_deg") + "6.000,\n6.010,\n6.020,1\n", ["2 cells", "'phi_deg'", "line 602"]),
    "missing times": (rows(TA, "time_s,phi_deg") + ",1.0\n6.010,1\n", ["a cell", "'time_s'", "line 602"]),
    "degrees in part": (rows(TA, "time_s,phi_deg") + "6.0,1.0°\n", ["'phi_deg'", "1 cells of 601 have a degree sign"]),
    "degrees in rad": (rows("{t:.3f},{a:.6f}°", "time_s,phi_rad"), ["'phi_rad' have degree signs", "'rad'"]),
    "a damaged first row": ("time_s,phi_deg\n0.0,x\n" + rows(TA), ["line 2 has a number, and a cell that is none"]),
    "a huge cell": (rows(TA, 'time_s,"phi_deg"') + '6.0,"' + 200_000 * "1" + '"\n', ["line 602", "field limit"]),
    "a huge cell without quotes": (rows(TA, "time_s,phi_deg") + "6.0," + 200_000 * "x" + "\n", ["xxx..."]),
}
TOLD = {"a text that is told": 'signal = ["way"]\nunit = "deg"\n'}


@pytest.mark.parametrize(("name", "content", "says"), [(k, *v) for k, v in REFUSED.items()], ids=REFUSED)
def test_what_is_no_angle_is_refused_by_name(name, content, says, tmp_path):
    assert len(refused(table(tmp_path, content, toml=TOLD.get(name, "")), *says)) < 500


def test_units_of_angles():
    assert conversion("turn", "rad").factor == pytest.approx(2.0 * np.pi)
    assert conversion("Grad", "rad") is None
    assert conversion("mrad", "rad").factor == pytest.approx(1e-3)


POINTS = "mass_A\t\t\tmass_B\t\t"


@pytest.mark.parametrize(
    ("heads", "pattern", "time"),
    [
        (POINTS, "{t:.3f}\t{a:.6f}\t0\t{t:.3f}\t1\t2", "mass_A t"),
        ("\tmass_A\t\tmass_B\t", "{t:.3f}\t{a:.6f}\t0\t1\t2", "t"),
    ],
    ids=["a time for each", "one time"],
)
def test_points_of_tracker_are_told_apart_by_their_names(heads, pattern, time, tmp_path):
    names = "t\tθ\tx\tt\tθ\tx" if time != "t" else "t\tθ\tx\tθ\tx"
    toml = f'time = "{time}"\ntime_unit = "s"\nsignal = ["mass_A θ"]\nunit = "deg"\n'
    path = table(tmp_path, rows(pattern, heads, names), "a.txt", toml)
    is_read(path)
    path.with_name("a.txt.toml").unlink()
    assert "mass_B θ" in run("info", path).stdout


def damaged_zip(path):
    """The data of its table are overwritten."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("Angle.csv", rows(TA, "t_s,phi_deg"))
    content = bytearray(path.read_bytes())
    content[60:400] = bytes(range(85)) * 4
    path.write_bytes(bytes(content))
    return path


def test_a_damaged_archive_is_one_line_and_other_files_go_on(tmp_path):
    bad = damaged_zip(tmp_path / "bad.zip")
    refused(bad, "bad.zip", "cannot be read as zip")
    damaged_zip(tmp_path / "bad.npz")
    refused(tmp_path / "bad.npz", "cannot be read as npz")
    good = table(tmp_path, rows(TA, "time_s,phi_deg"))
    done = run("fit", bad, good)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert "cannot be read as zip" in " ".join(done.stderr.split())
    assert "a.csv" in done.stdout


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "it is empty"),
        (bytes(range(128, 228)), "it is no archive of arrays"),
        (b"time_s,phi_deg\n0,1\n", "it begins as text"),
        (b"\x93NUMPY\x01\x00", "it is one array"),
    ],
    ids=["empty", "garbage", "text", "npy"],
)
def test_what_is_no_npz_is_said_without_pickles(content, says, tmp_path):
    path = tmp_path / "a.npz"
    path.write_bytes(content)
    assert "pickle" not in refused(path, "cannot be read as npz", says)
    assert run("info", path).returncode == 2


def test_arrays_of_npz_by_their_kind(tmp_path):
    start = np.datetime64("2024-03-01T12:00:00", "ms")
    dates = start + (1e3 * TIME_S).round().astype("timedelta64[ms]")
    path = tmp_path / "a.npz"
    np.savez(path, time=dates, phi_deg=ANGLE_DEG, who=np.array(["DC"] * 600), note=np.array("hello"))
    is_read(path)
    np.savez(path, time_s=TIME_S, phi_rad=ANGLE_RAD + 0j)
    refused(path, "'phi_rad'", "complex numbers")
    np.savez(path, time_s=TIME_S, phi_rad=ANGLE_RAD.astype(object))
    refused(path, "'phi_rad'", "Python objects")


def matlab_7_3(path, values, **options):
    with h5py.File(path, "w", **options) as file:
        file["time_s"] = TIME_S
        file["phi_rad"] = values


def test_files_of_matlab(tmp_path):
    path = tmp_path / "a.mat"
    matlab_7_3(path, ANGLE_RAD, userblock_size=512)
    is_read(path)
    matlab_7_3(path, ANGLE_RAD)
    is_read(path)
    pairs = np.zeros(600, dtype=[("real", "f8"), ("imag", "f8")])
    matlab_7_3(path, pairs, userblock_size=512)
    refused(path, "'phi_rad'", "complex numbers")
    savemat(path, {"time_s": TIME_S, "phi_rad": ANGLE_RAD + 0.1j})
    refused(path, "'phi_rad'", "complex numbers")
    savemat(path, {"time_s": TIME_S, "phi_rad": ANGLE_RAD})
    refused(path.rename(tmp_path / "a.h5"), "let its name end in .mat")


def test_a_long_text_is_read_in_blocks_with_the_lines_of_its_errors():
    line = "{:.6f},{:.6f},0.123456789\n"
    body = [line.format(k / 100.0, k % 7) for k in range(120_000)]
    found = text_table("".join(["t_s,phi_deg,u\n", *body]).encode(), "a.csv")
    np.testing.assert_array_equal(found["t_s"], np.round(np.arange(120_000) / 100.0, 6))
    np.testing.assert_array_equal(found["phi_deg"], np.arange(120_000) % 7)
    assert found.lines[-1] == 120_001
    body[100_000] = "1000.0,none,1\n"
    with pytest.raises(pd_.RecordingError, match="'none' in line 100002"):
        text_table("".join(["t_s,phi_deg,u\n", *body]).encode(), "a.csv")
