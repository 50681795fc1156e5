"""`platform-daemon info` and `plot`."""

from tests.kit.command_line import assert_one_line_error, here, run


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
