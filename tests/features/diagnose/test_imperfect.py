"""A specimen with a manufacturing error, measured and diagnosed as a user does, against the simulated truth."""

import json

import pytest

from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recorded_fits import read_fit
from platform_daemon.core.recordings.truth import read_truth
from tests.kit.command_line import run


@pytest.mark.long
def test_the_imperfect_threads_error_has_a_name_its_parameters_are_true_and_fits_use_it(tmp_path):
    shot, report, fits = tmp_path / "t.h5", tmp_path / "t.json", tmp_path / "fit.json"
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
    # They act alike, and noise decides which of them leaves less.
    sizes = {"stator_tilt": 8.727e-4, "lateral_displacement": 1.55e-5}
    assert {effect["id"], *effect["indistinguishable_from"]} == set(sizes)
    size = sizes[effect["id"]]
    assert abs(effect["strength"]["value"] - size) < 3 * effect["strength"]["std"] < 0.06 * size
    assert not found["next_measurements"]
    assert any("no measurement that is known here would part" in note for note in found["notes"])
    assert found["held_out"]["chi2_per_dof_after"] < 1.1
    assert "the motion leaves its plane" in done.stdout
    assert "stator tilted by 0.0" in done.stdout
    for name in ("f_nat_hz", "m_r_am2", "lambda_per_s"):
        after = found["parameters_after"][name]
        assert abs(after["value"] - truth[name]) < 3 * after["std"], name
        before = found["parameters_before"][name]["value"]
        assert abs(before - truth[name]) > 4 * abs(after["value"] - truth[name]), name

    models = ("--models", tmp_path / "models")
    assert run("adopt", report, "--name", "tilted", *models).returncode == 0
    again = run("characterise", "--from", shot, "--variant", "tilted", "--json", fits, *models, timeout=600)
    assert again.returncode == 0, again.stderr
    tables = json.loads(fits.read_text())
    assert any("figure of a shot" in note for note in tables["notes"])
    for window in ("n50", "d30"):
        (frame,) = tables[f"{window}_fits"]["frames"]
        assert any(effect["id"] in note and "with those of what is held" in note for note in frame["notes"])
        assert frame["chi2_per_dof"] < 1.05
        for name in ("f_nat_hz", "m_r_am2", "lambda_per_s"):
            one = frame["parameters"][name]
            assert abs(one["value"] - truth[name]) < 3.5 * one["std"], (window, name)
    series, online = tmp_path / "series.h5", tmp_path / "series.json"
    made = run(
        "measure", "--resonator", "thread_imperfect", "--field-ut", "240", "--rx-s", "2", "--shots", "2",
        "--pause-s", "20", "--variant", "tilted", "--out", series, "--json", online, *models, timeout=600,
    )  # fmt: skip
    assert made.returncode == 0, made.stderr
    assert read_fit(open_recording(series), "d30").correction.startswith('[{"model": "tilted@1"')
    for fit, true in zip(json.loads(online.read_text())["fit"]["frames"], read_truth(series), strict=True):
        assert fit["verdict"] == "good", fit["reason"]
        assert fit["correction"]["model"] == "tilted@1"
        for name in ("f_nat_hz", "m_r_am2", "lambda_per_s"):
            one = fit["parameters"][name]
            assert abs(one["value"] - true["simulated"][name]) < 3.5 * one["std"], name
            assert one["std"] > fit["correction"]["error"][name] > 0.0

    k = frame["covariance"]["parameters"].index("m_r_am2")
    assert frame["covariance"]["matrix"][k][k] == pytest.approx(frame["parameters"]["m_r_am2"]["std"] ** 2)
    refused = run("slide", shot, "--variant", "tilted", *models)
    assert refused.returncode == 2
    assert effect["id"] in refused.stderr
