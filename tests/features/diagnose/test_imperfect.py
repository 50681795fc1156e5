"""A specimen with a manufacturing error, measured and diagnosed as a user does, against the simulated truth."""

import json

import pytest

from platform_daemon.core.recordings.truth import read_truth
from tests.kit.command_line import run


@pytest.mark.long
def test_the_imperfect_threads_error_has_a_name_and_its_parameters_are_true(tmp_path):
    shot, report = tmp_path / "t.h5", tmp_path / "t.json"
    made = run(
        "measure", "--resonator", "thread_imperfect", "--field-ut", "240", "--rx-s", "2", "--shots", "1",
        "--out", shot, timeout=300,
    )  # fmt: skip
    assert made.returncode == 0, made.stderr
    done = run("diagnose", shot, "--json", report, timeout=600)
    assert done.returncode == 0, done.stderr
    found, truth = json.loads(report.read_text()), read_truth(shot)[0]["simulated"]
    (effect,) = found["effects"]
    assert found["verdict"] == "explained"
    assert effect["id"] == "stator_tilt"
    assert effect["strength"]["value"] == pytest.approx(8.727e-4, rel=0.05)
    assert "the motion leaves its plane" in done.stdout
    assert "stator tilted by 0.0" in done.stdout
    for name in ("f_nat_hz", "m_r_am2", "lambda_per_s"):
        after = found["parameters_after"][name]
        assert abs(after["value"] - truth[name]) < 4 * after["std"], name
        before = found["parameters_before"][name]["value"]
        assert abs(before - truth[name]) > 4 * abs(after["value"] - truth[name]), name
