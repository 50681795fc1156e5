"""Tables of time and signal: opened by the library and by commands, with the units that their columns name."""

import numpy as np
import pytest

import platform_daemon as pd_
from tests.kit.command_line import assert_one_line_error, here, run

RATE_HZ = 10_000.0


@pytest.fixture(scope="module")
def sim():
    return pd_.simulate("jewel", phi_max_deg=53, seconds=0.6, noise="paper", seed=1, sampling_rate_hz=RATE_HZ)


def write(path, names, columns, separator=",", decimal="."):
    rows = [separator.join(f"{value:.9g}".replace(".", decimal) for value in row) for row in np.column_stack(columns)]
    path.write_text("\n".join([separator.join(names), *rows]) + "\n")
    return path


def table(sim, scale=1.0, time=1.0):
    return [time * sim.time_s(), *(scale * sim.signal())]


@pytest.mark.parametrize(
    ("names", "scale", "time", "separator", "decimal"),
    [
        (("time_s", "x_am2_per_s", "y_am2_per_s", "z_am2_per_s"), 1.0, 1.0, ",", "."),
        (("t [ms]", "x (mA m^2/s)", "y (mA m^2/s)", "z (mA m^2/s)"), 1e3, 1e3, ";", ","),
        (("Time [s]", "x [A m²/s]", "y [A m²/s]", "z [A m²/s]"), 1.0, 1.0, "\t", "."),
    ],
    ids=["names", "brackets and decimal comma", "tabs"],
)
def test_a_table_says_by_its_columns_what_it_holds(sim, tmp_path, names, scale, time, separator, decimal):
    path = write(tmp_path / "own.csv", names, table(sim, scale, time), separator, decimal)
    found = pd_.open(path)
    assert found.quantity() == "dmdt"
    assert found.sampling_rate_hz() == pytest.approx(RATE_HZ, rel=1e-6)
    np.testing.assert_allclose(found.signal(), sim.signal(), rtol=1e-6, atol=1e-8)


def test_columns_and_units_are_told_by_the_caller_or_by_a_file(sim, tmp_path):
    path = write(tmp_path / "own.txt", ("a", "b", "c", "d"), table(sim, 1e3, 1e6))
    told = {"time": "a", "signal": ["b", "c", "d"], "time_unit": "us", "unit": "mV"}
    assert pd_.open(path, **told).quantity() == "voltage"
    (tmp_path / "own.txt.toml").write_text('time = "a"\nsignal = ["b"]\ntime_unit = "us"\nunit = "V"\n')
    assert pd_.open(path).signal().shape == (1, 6000)


def test_npz_holds_arrays_by_the_same_names(sim, tmp_path):
    np.savez(tmp_path / "own.npz", time_s=sim.time_s(), dmdt_am2_per_s=sim.signal())
    np.testing.assert_allclose(pd_.open(tmp_path / "own.npz").signal(), sim.signal(), rtol=1e-12, atol=1e-15)


def test_an_angle_in_degrees_is_converted(tmp_path):
    time_s = np.arange(4000) / 200.0
    angle_deg = 20.0 * np.exp(-0.05 * time_s) * np.cos(2 * np.pi * 3.1 * time_s)
    path = write(tmp_path / "swing.csv", ("t_s", "phi_deg"), [time_s, angle_deg])
    np.testing.assert_allclose(pd_.open(path).signal()[0], np.deg2rad(angle_deg), atol=1e-7)


@pytest.mark.long
def test_commands_take_a_table_as_they_take_a_recording(sim, tmp_path):
    names = ("time_s", "x_am2_per_s", "y_am2_per_s", "z_am2_per_s")
    path = write(tmp_path / "own.csv", names, table(sim))
    for words in (["fit", path, "--variant", "jewel"], ["harmonics", path], ["diagnose", path, "--variant", "jewel"]):
        out = run(*words)
        assert out.returncode == 0, out.stderr
        assert "213.2" in out.stdout
    refused = run("fit", write(tmp_path / "bare.csv", ("t", "x"), table(sim)[:2]))
    assert refused.returncode == 2
    assert "bare.csv.toml" in refused.stderr


@pytest.mark.parametrize("columns", ["t_s,x_am2_per_s,y_am2_per_s,z_am2_per_s", "t,θ", "Time (s),Angle (°)"])
def test_commands_that_need_specimen_and_time_say_what_a_table_is(columns, tmp_path):
    path, details = tmp_path / "own.csv", tmp_path / "details.toml"
    path.write_text(f"{columns}\n" + "".join(f"{k}{',0.1' * columns.count(',')}\n" for k in range(99)))
    who = 'name = "L", city = "Lübeck", country = "DE"'
    details.write_text(f'number = "1"\nperson = "M"\nlaboratory = {{ {who} }}\ncustomer = {{ {who} }}\n')
    for words in (("measurand", "read", path), ("certificate", "jewel", path, "--details", details)):
        says = ("own.csv: is a table", "nor when its shots were made", "recording of this software")
        assert_one_line_error(here(*words), 2, *says)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("time_s,x\n0,1\n1,2\n", "unit of the column 'x' is not known"),
        ("a,x_v\n0,1\n1,2\n", "no column is called time"),
        ("time_s,x_v\n0,1\n1\n", "line 3 has 1, the others 2"),
        ("time_s,x_v\n0,one\n1,2\n", "'one' in line 2 is no number"),
        ("time_s,x_v,x_v\n0,1,0\n1,2,0\n", "two columns are called 'x_v'"),
        ("time_s,x_v,y_deg\n0,1,1\n1,2,1\n", "different quantities"),
        ("time_m,x_v\n0,1\n1,2\n", "'time_m'"),
        ("time_s,x_v\n", "holds no table"),
        ("", "holds no table"),
    ],
)
def test_a_table_that_is_wrong_is_refused_with_its_place(tmp_path, text, says):
    path = tmp_path / "wrong.csv"
    path.write_text(text)
    with pytest.raises(pd_.RecordingError, match=says) as found:
        pd_.open(path)
    assert str(path) in found.value.where
    assert found.value.remedy


def test_a_column_that_is_not_there(tmp_path, sim):
    path = write(tmp_path / "own.csv", ("time_s", "x_v"), table(sim)[:2])
    with pytest.raises(pd_.RecordingError, match="no column 'y_v'") as found:
        pd_.open(path, signal="y_v")
    assert "'x_v'" in found.value.remedy
    with pytest.raises(pd_.InputError, match="not a table"):
        pd_.open(tmp_path / "own.h5", signal="y_v")


@pytest.mark.parametrize("text", ["time = 3", "times = 't'", "signal = []", "time ="])
def test_a_file_that_tells_wrongly_is_refused(tmp_path, sim, text):
    path = write(tmp_path / "own.csv", ("time_s", "x_v"), table(sim)[:2])
    (tmp_path / "own.csv.toml").write_text(text)
    with pytest.raises(pd_.RecordingError, match=r"own\.csv\.toml"):
        pd_.open(path)


def test_bytes_that_are_no_npz_are_refused(tmp_path):
    (tmp_path / "own.npz").write_bytes(b"no archive")
    with pytest.raises(pd_.RecordingError, match="npz"):
        pd_.open(tmp_path / "own.npz")


def test_a_table_of_windows_and_of_a_spreadsheet_is_the_same_table(tmp_path):
    """Byte order marks before the table and before the file that tells its columns, quotes around every cell."""
    time_s, angle_rad = 0.01 * np.arange(200), np.linspace(0.3, 0.1, 200)
    rows = [f'"{a:.4f}","{b:.8f}"' for a, b in zip(time_s, angle_rad, strict=True)]
    path = tmp_path / "saved.csv"
    path.write_text("\r\n".join(['"when","how far"', *rows, ""]), encoding="utf-8-sig")
    told = "time = 'when'\ntime_unit = 's'\nsignal = ['how far']\nunit = 'rad'\n"
    (tmp_path / "saved.csv.toml").write_text(told, encoding="utf-8-sig")
    np.testing.assert_allclose(pd_.open(path).signal()[0], angle_rad, atol=1e-8)
    path.write_text(path.read_text(encoding="utf-8-sig"), encoding="utf-16")
    np.testing.assert_allclose(pd_.open(path).signal()[0], angle_rad, atol=1e-8)


def test_an_empty_cell_is_no_zero(tmp_path):
    path = tmp_path / "own.csv"
    path.write_text("time_s,x_v\n" + "".join(f"{k},{'' if k == 50 else k % 7}\n" for k in range(100)))
    with pytest.raises(pd_.InputError, match=r"finite|missing"):
        pd_.open(path)
