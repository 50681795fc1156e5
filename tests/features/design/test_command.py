"""`platform-daemon design | defects`."""

import json
import time

import pytest

from tests.kit.command_line import assert_one_line_error, here

TILT = ("defects", "--bearing", "jewel", "--defect", "stator_tilt")
FLAT = ("--cup-radius-over-r", "inf")


def test_design_says_that_the_printed_friction_does_not_follow_from_the_printed_mu(tmp_path):
    done = here("design", "--json", tmp_path / "d.json")
    assert done.returncode == 0, done.stderr
    for told in ("14.625 mAm2", "229.31 Hz", "131.50 mN", "1.082 mN", "14.09 mT", "1.3572", "144.9 nNm", "1460 rad/s2"):
        assert told in done.stdout
    assert "115.9 nNm and T_f/I = 1168 rad/s2; its equations give them with mu = 0.12" in done.stdout
    found = json.loads((tmp_path / "d.json").read_text())
    assert found["friction"]["t_f_nm"] == pytest.approx(144.9e-9, rel=1e-3)
    assert found["measured"] is None


@pytest.mark.parametrize(("name", "force"), [("jewel", 5.850e-3), ("thread", 6.776e-3)])
def test_design_of_a_resonator_ends_with_the_six_steps(tmp_path, name, force):
    done = here("design", "--resonator", name, "--json", tmp_path / "d.json")
    assert done.returncode == 0, done.stderr
    found = json.loads((tmp_path / "d.json").read_text())
    (procedure,) = found["procedures"]
    assert procedure["f_perp_n"] == pytest.approx(force, rel=1e-4)
    assert [step["step"] for step in procedure["steps"]] == [1, 2, 3, 4, 5, 6]
    assert found["measured"]["f_nat_hz"] in (213.25, 215.69)
    assert (found["friction"] is None) == (name == "thread")
    for step in procedure["steps"]:
        assert f"  {step['step']}. {step['what']}  [{step['source']}]" in done.stdout


def test_each_step_follows_from_those_before(tmp_path):
    here("design", "--resonator", "jewel", "--json", tmp_path / "d.json")
    steps = [s["values"] for s in json.loads((tmp_path / "d.json").read_text())["procedures"][0]["steps"]]
    centre, axis, d = steps[1]["centre_m"], steps[2]["axis"], steps[2]["reference_point_m"]
    assert steps[1]["dy_c_m"] == pytest.approx(abs(centre[1]))
    assert [c - 1.5e-3 * a for c, a in zip(centre, axis, strict=True)] == pytest.approx(d)
    anchor = [0.0, 0.0, 4.7e-3 + 1e-3]
    assert [c + 1e-3 * a for c, a in zip(centre, axis, strict=True)] == pytest.approx(anchor, abs=1e-12)


def test_defects_writes_every_size_at_every_deflection(tmp_path):
    done = here(*TILT, "--eps-deg", "0,2", "--phi-deg", "0:30:2", "--json", tmp_path / "d.json")
    assert done.returncode == 0, done.stderr
    found = json.loads((tmp_path / "d.json").read_text())
    assert (found["bearing"], found["defect"]) == ("jewel", "stator_tilt")
    assert [(c["eps_deg"], c["phi_deg"]) for c in found["cases"]] == [(0, 0), (0, 30), (2, 0), (2, 30)]
    assert found["cases"][1] == {"eps_deg": 0.0, "phi_deg": 30.0, "f_perp_n": 0.0, "dy_c_m": 0.0,
                                 "alpha_rad": pytest.approx(1.5707963267948966)}  # fmt: skip
    assert found["cases"][3]["f_perp_n"] == pytest.approx(5.850e-3, rel=1e-4)
    assert "5.85" in done.stdout


def test_displacements_are_in_mm(tmp_path):
    done = here("defects", "--bearing", "thread", "--defect", "lateral", "--dy-mm", "0.1", "--thread-length-over-r",
                "inf", "--json", tmp_path / "d.json")  # fmt: skip
    assert done.returncode == 0, done.stderr
    found = json.loads((tmp_path / "d.json").read_text())
    assert found["thread_length_over_r"] == "inf"
    (case,) = found["cases"]
    assert case["dy_mm"] == 0.1
    assert case["f_perp_n"] == pytest.approx(0, abs=1e-12)
    assert case["dy_c_m"] == pytest.approx(1e-4)


def test_a_sweep_of_100_by_100_takes_seconds_and_is_drawn(tmp_path):
    began = time.monotonic()
    done = here(*TILT, "--eps-deg", "0:10:100", "--phi-deg", "0:90:100", "--json", tmp_path / "d.json",
                "--png", tmp_path / "d.png")  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert time.monotonic() - began < 20
    assert len(json.loads((tmp_path / "d.json").read_text())["cases"]) == 10_000
    assert (tmp_path / "d.png").read_bytes().startswith(b"\x89PNG")
    assert "10000 cases" in done.stdout


@pytest.mark.long
@pytest.mark.parametrize(
    "arguments",
    [
        ("jewel", "jewel_tilt", "--eps-deg", "60", *FLAT),  # some of the family come to rest nowhere
        ("jewel", "lateral", "--dy-mm", "0.5", "--direction", "across"),
        ("jewel", "stator_tilt", "--eps-deg", "0"),
        ("thread", "rotor_tilt", "--eps-deg=-3,3", "--resonator", "thread"),
        ("thread", "lateral", "--dy-mm", "2", "--phi-deg", "0:90:20", "--thread-length-over-r", "3"),
    ],
)
def test_pictures_of_every_defect(tmp_path, arguments):
    bearing, defect, *rest = arguments
    done = here("defects", "--bearing", bearing, "--defect", defect, *rest, "--png", tmp_path / "d.png")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "d.png").stat().st_size > 20_000


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("defects", "--bearing", "thread", "--defect", "jewel_tilt", "--eps-deg", "1"), ("--defect", "rotor_tilt")),
        (("defects", "--bearing", "jewel", "--defect", "rotor_tilt", "--eps-deg", "1"), ("--defect", "jewel_tilt")),
        (("defects", "--bearing", "jewel", "--defect", "lateral", "--eps-deg", "1"), ("--eps-deg", "--dy-mm")),
        (("defects", "--bearing", "spring", "--defect", "lateral", "--dy-mm", "1"), ("--bearing", "spring")),
        ((*TILT, "--dy-mm", "1"), ("--dy-mm", "--eps-deg")),
        ((*TILT, "--eps-deg", "1", "--dy-mm", "1"), ("--dy-mm", "--eps-deg")),
        (TILT, ("--eps-deg", "missing")),
        ((*TILT, "--eps-deg", "nan"), ("--eps-deg", "finite")),
        ((*TILT, "--eps-deg", "1,,2"), ("--eps-deg", "'1,,2'")),
        ((*TILT, "--eps-deg", "0:1:1"), ("--eps-deg", "COUNT")),
        ((*TILT, "--eps-deg", "inf"), ("--eps-deg", "finite")),
        ((*TILT, "--eps-deg", "100"), ("--eps-deg", "at most 90")),
        ((*TILT, "--eps-deg", "1", "--phi-deg", "120"), ("--phi-deg", "at most 90")),
        ((*TILT, "--eps-deg", "0:1:200", "--phi-deg", "0:1:200"), ("40000 cases",)),
        ((*TILT, "--eps-deg", "1", "--cup-radius-over-r", "-2"), ("--cup-radius-over-r", "convex")),
        ((*TILT, "--eps-deg", "1", "--cup-radius-over-r", "1"), ("--cup-radius-over-r", "larger")),
        ((*TILT, "--eps-deg", "1", "--cup-radius-over-r", "nan"), ("--cup-radius-over-r", "or inf")),
        ((*TILT, "--eps-deg", "1", "--thread-length-over-r", "8"), ("--thread-length-over-r", "no thread")),
        ((*TILT, "--eps-deg", "1", "--pivot", "contact"), ("--pivot", "only a jewel")),
        ((*TILT, "--eps-deg", "1", "--direction", "across"), ("--direction", "displacement")),
        ((*TILT, "--eps-deg", "1", "--json", "x.csv"), ("end in .json",)),
        ((*TILT, "--eps-deg", "1", "--png", "x.jpg"), ("end in .png",)),
        ((*TILT, "--eps-deg", "1", "--resonator", "spring"), ("spring",)),
        (("defects", "--bearing", "jewel", "--defect", "jewel_tilt", "--eps-deg", "1,70", *FLAT), ("70 deg", "touch")),
        (("defects", "--bearing", "thread", "--defect", "lateral", "--dy-mm", "1", "--thread-length-over-r", "0"),
         ("--thread-length-over-r", "positive")),
        (("design", "--resonator", "spring"), ("spring",)),
        (("design", "--json", "x.csv"), ("end in .json",)),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_one_line_that_names_the_option(tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    assert_one_line_error(here(*arguments), 2, "Remedy", *words)
    assert list(tmp_path.iterdir()) == []
