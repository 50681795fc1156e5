"""`platform-daemon slide`."""

import json

import pytest

from tests.kit.command_line import assert_one_line_error, here
from tests.kit.example_copies import copies
from tests.kit.specimen_files import pendulum, swing


def test_slide_draws_flat_lines_and_says_how_flat(tmp_path):
    (path,) = copies(tmp_path, 1)
    done = here("slide", path, "--window", "0.12", "--out", tmp_path / "s.png", "--json", tmp_path / "s.json")
    assert done.returncode == 0, done.stderr
    assert "f_nat_hz" in done.stdout
    assert (tmp_path / "s.png").read_bytes().startswith(b"\x89PNG")
    report = json.loads((tmp_path / "s.json").read_text())
    assert [w["verdict"] for w in report["windows"]] == ["good"] * 8
    assert report["flatness"]["m_r_am2"]["probability"] > 1e-4
    assert_one_line_error(here("slide", path, "--window", "5"), 2, "--window")
    assert_one_line_error(here("slide", path, "--lambda", "loose"), 2, "--lambda")
    assert_one_line_error(here("slide", path, "--frame", "9"), 2, "frame 9")


def test_slide_goes_along_an_angle(tmp_path):
    angle = pendulum(tmp_path, *swing(seconds=40.0, decay_per_s=0.02))
    done = here("slide", angle, "--variant", "thread_small_angle", "--window", "8", "--json", tmp_path / "s.json")
    assert done.returncode == 0, done.stderr
    report = json.loads((tmp_path / "s.json").read_text())
    assert [w["verdict"] for w in report["windows"]] == ["good"] * 5
    assert report["flatness"]["f_nat_hz"]["mean"] == pytest.approx(2.0, abs=1e-3)
    two = here("slide", angle, "--variant", "thread_small_angle", "--window", "20")
    assert two.stdout.strip() == "good windows of 20 s: 2; a slope needs three, so shorten them"
