"""`platform-daemon info` and `plot`."""

import base64
import re
import webbrowser

import numpy as np
import pytest
import scipy.io

from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.schemas.recordings import AngleInfo
from platform_daemon.features.fit import ring_down_page
from tests.kit.command_line import assert_one_line_error, here, run
from tests.kit.html_pages import elements
from tests.kit.specimen_files import pendulum, swing


def test_plot_writes_a_png_and_info_says_what_the_file_holds(measured):
    done = run("plot", measured / "j.h5", "--frame", 1)
    assert done.returncode == 0, done.stderr
    assert (measured / "j-frame1.png").read_bytes().startswith(b"\x89PNG")
    assert_one_line_error(here("plot", measured / "j.h5", "--frame", 1), 2, "--force")
    assert_one_line_error(here("plot", measured / "j.h5", "--frame", 7), 2, "frame 7")
    assert "jewel" in here("info", measured / "j.h5").stdout


def test_shots_are_rows_and_an_excitation_that_all_share_is_told_once(measured, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    text = here("info", measured / "j.h5").stdout
    assert text.count("periods of 212 Hz") == 1
    rows = [line.split("│")[1:6] for line in text.splitlines() if "good" in line and "│" in line]
    assert [row[0].strip() for row in rows] == ["0", "1"]
    assert [row[1].strip() for row in rows] == ["1", "2"]
    assert "sensitivity / mT A⁻¹" in text
    assert max(map(len, text.splitlines())) <= 80
    assert "None" not in text


@pytest.fixture
def opened(monkeypatch):
    pages = []
    monkeypatch.setattr(webbrowser, "open", pages.append)
    monkeypatch.setattr(ring_down_page.sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    return pages


def test_an_interactive_plot_is_a_page_with_all_samples_that_needs_nothing_from_elsewhere(measured, opened):
    done = here("plot", measured / "j.h5", "--frame", 0, "--interactive")
    assert done.returncode == 0, done.stderr
    path = measured / "j-frame0.html"
    assert done.stdout.strip() == str(path)
    assert not path.with_suffix(".png").exists()
    page = path.read_text()
    seen = elements(page)
    assert not {"link", "iframe", "object", "img"} & {e.tag for e in seen}
    assert not any(e.get(key) for e in seen for key in ("src", "href", "srcset", "data", "action"))
    assert "fetch(" not in page
    assert "import" not in page
    data = {e.get("id"): np.frombuffer(base64.b64decode(e.text), "<f4") for e in seen if e.get("type") == "text/plain"}
    samples = open_recording(measured / "j.h5").rx_volts(0).size
    assert data["signal_data"].size == data["residual_data"].size == samples
    assert 0.0 < np.std(data["residual_data"]) < 0.1 * np.std(data["signal_data"])
    assert opened == []
    assert_one_line_error(here("plot", measured / "j.h5", "--interactive"), 2, "j-frame0.html", "--force")


def test_an_interactive_plot_is_opened_in_the_browser_where_there_is_a_screen(tmp_path, opened, monkeypatch):
    monkeypatch.setenv("DISPLAY", ":0")
    ring_down_page.open_in_browser(tmp_path / "page.html")
    assert opened == [(tmp_path / "page.html").as_uri()]


@pytest.mark.parametrize(
    ("columns", "shown"),
    [
        ("u1 (mV),u2 (mV),u3 (mV)", None),
        ("x_am2_per_s,y_am2_per_s,z_am2_per_s", "the samples are dm/dt in A m²/s already"),
    ],
)
def test_info_of_a_table_says_what_it_holds(tmp_path, columns, shown):
    rows = [f"{k / 1000},{(-1) ** k},0.5,0.1" for k in range(2000)]
    file = tmp_path / "own.csv"
    file.write_text("\n".join([f"t [s],{columns}", *rows]))
    text = here("info", file).stdout
    assert "1000 Hz" in text
    assert "2000 │ 2000" in text
    assert f"({file.stat().st_size / 1e6:.3g} MB, table)" in text
    assert "sensitivity" not in text
    assert shown is None or shown in text


def swing_table(path, names, *, scale=1.0):
    time_s = np.arange(400) / 200.0
    angle_deg = scale * 20.0 * np.exp(-0.5 * time_s) * np.cos(20.0 * time_s)
    columns = [time_s, angle_deg, angle_deg][: len(names)]
    rows = [",".join(f"{value:.9g}" for value in row) for row in np.column_stack(columns)]
    path.write_text("\n".join([",".join(names), *rows]))
    return path


def test_info_of_a_table_of_an_angle_says_what_was_read_and_what_comes_next(tmp_path):
    file = swing_table(tmp_path / "my swing.csv", ("Time (s)", "Angle (deg)", "Speed (rad/s)"))
    done = here("info", file, "--json", tmp_path / "info.json")
    assert done.returncode == 0, done.stderr
    assert re.search(r"Angle \(deg\) +│ +400 │ deg +│ .* 20 │ signal", done.stdout)
    assert re.search(r"Speed \(rad/s\) .* left out", done.stdout)
    for word in ("200 Hz", "2 s", "to 20° (", "0.3491 rad", f"next: platform-daemon plot '{file}'"):
        assert word in done.stdout
    facts = AngleInfo.model_validate_json((tmp_path / "info.json").read_bytes())
    assert (facts.samples, facts.highest_rad) == (400, pytest.approx(np.radians(20.0)))
    assert [each.read_as for each in facts.columns] == ["time", "signal", None]


def without_units(folder):
    return swing_table(folder / "own.csv", ("t", "x", "θ_{r}"))


def without_names(folder):
    return swing_table(folder / "own.dat", ("a", "phi"))


def matrix(folder):
    time_s = np.arange(400) / 200.0
    scipy.io.savemat(folder / "own.mat", {"data": np.column_stack([time_s, np.cos(20.0 * time_s)])})
    return folder / "own.mat"


@pytest.mark.parametrize(
    ("make", "shown", "holds"),
    [(without_units, "θ_{r}", " rad)"), (without_names, "phi", " rad)"), (matrix, "data(:,2)", "channels")],
)
def test_info_of_a_table_that_says_too_little_gives_the_lines_that_it_lacks(tmp_path, make, shown, holds):
    """They make it readable as they are printed."""
    file = make(tmp_path)
    done = here("info", file)
    assert_one_line_error(done, 2, file.name)
    lines = [line for line in done.stdout.splitlines() if re.match(r"(time|time_unit|signal|unit) = ", line)]
    assert len(lines) == 4
    assert f'signal = ["{shown}"]' in lines
    file.with_name(f"{file.name}.toml").write_text("\n".join(lines), encoding="utf-8")
    again = here("info", file)
    assert again.returncode == 0, again.stderr
    assert holds in again.stdout


def test_info_of_a_table_that_cannot_be_one_signal_shows_its_columns_and_says_why(tmp_path):
    file = swing_table(tmp_path / "own.csv", ("t_s", "phi_rad"))
    done = here("info", file)
    assert_one_line_error(done, 2, "beyond pi to either side", "degrees")
    assert "phi_rad" in done.stdout
    assert ".toml" not in done.stdout


def test_info_of_an_angle_series(tmp_path):
    time_s, angle = swing()
    done = here("info", pendulum(tmp_path, time_s, angle))
    assert done.returncode == 0, done.stderr
    assert "angle series" in done.stdout
    assert f"{angle.size}" in done.stdout
