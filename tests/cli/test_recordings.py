"""`platform-daemon info` and `plot`."""

from tests.kit.command_line import assert_one_line_error, here, run


def test_plot_writes_a_png_and_info_says_what_the_file_holds(measured):
    done = run("plot", measured / "j.h5", "--frame", 1)
    assert done.returncode == 0, done.stderr
    assert (measured / "j-frame1.png").read_bytes().startswith(b"\x89PNG")
    assert_one_line_error(here("plot", measured / "j.h5", "--frame", 1), 2, "--force")
    assert_one_line_error(here("plot", measured / "j.h5", "--frame", 7), 2, "frame 7")
    assert "jewel" in here("info", measured / "j.h5").stdout
