"""`platform-daemon fit` of one file, as a user meets it: what it gives, what can be asked, what it refuses."""

import json

import h5py
import numpy as np
import pytest

from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.estimation.refusal import Refusal
from platform_daemon.features.fit.fit import fit_frame
from platform_daemon.features.fit.fit_request import FitRequest
from tests.kit.command_line import assert_one_line_error, here, run
from tests.kit.example_copies import copies
from tests.kit.specimen_files import pendulum, swing

SHORT = ("--window", "0.1")


def test_fit_writes_the_fixed_json_form(measured):
    done = run("fit", measured / "j.h5", "--json", measured / "fit.json", "--window", "n50")
    assert done.returncode == 0, done.stderr
    report = json.loads((measured / "fit.json").read_text(), parse_constant=lambda c: pytest.fail(f"{c} in JSON"))
    assert set(report) >= {"file", "variant", "window_s", "frames", "summary"}
    frame = report["frames"][0]
    assert set(frame) >= {"frame", "verdict", "reason", "parameters", "r2", "nrmse", "chi2_per_dof", "seconds"}
    assert set(frame["parameters"]) == {
        "f_nat_hz", "m_r_am2", "lambda_per_s", "tf_over_i_rad_per_s2", "phi_max_rad", "psi_start_rad",
        "rodrigues_x", "rodrigues_y", "rodrigues_z",
    }  # fmt: skip
    assert set(report["summary"]["f_nat_hz"]) == {"mean", "std"}


def test_a_parameter_held_fixed_has_no_standard_deviation(measured):
    done = here("fit", measured / "j.h5", "--fix", "lambda_per_s=0.0978", "--json", measured / "fixed.json")
    assert done.returncode == 0, done.stderr
    found = json.loads((measured / "fixed.json").read_text())["frames"][0]["parameters"]["lambda_per_s"]
    assert found == {"value": 0.0978, "std": None}


def test_a_hint_holds_a_loss_only_where_the_window_cannot_tell_it(measured):
    found = {}
    for window in ("0.05", "0.5"):
        path = measured / f"hint{window}.json"
        done = here("fit", measured / "j.h5", "--window", window, "--hint", "lambda_per_s=0.24", "--json", path)
        assert done.returncode == 0, done.stderr
        found[window] = json.loads(path.read_text())["frames"][0]
    assert found["0.05"]["parameters"]["lambda_per_s"] == {"value": 0.24, "std": None}
    assert any(note.startswith("hint used: lambda_per_s") for note in found["0.05"]["notes"])
    assert found["0.5"]["parameters"]["lambda_per_s"]["std"] > 0
    assert not any("hint" in note for note in found["0.5"]["notes"])


@pytest.mark.parametrize("sensitivity", [np.ones((3, 3)), np.eye(3)[:2]])
def test_a_calibration_that_cannot_be_inverted_is_bad_input(measured, tmp_path, sensitivity):
    with h5py.File(measured / "j.h5") as source, h5py.File(tmp_path / "cal.h5", "w") as target:
        source.copy("calibration", target)
        del target["calibration/sensitivity"]
        target["calibration/sensitivity"] = sensitivity
    done = here("fit", measured / "j.h5", "--calibration", tmp_path / "cal.h5", "--json", tmp_path / "f.json")
    assert_one_line_error(done, 2, "sensitivity")
    assert not (tmp_path / "f.json").exists()


def test_fit_with_another_calibration_scales_the_moment(measured):
    with h5py.File(measured / "j.h5") as source, h5py.File(measured / "cal.h5", "w") as target:
        source.copy("calibration", target)
        target["calibration/sensitivity"][...] *= 2
    done = here("fit", measured / "j.h5", "--calibration", measured / "cal.h5", "--json", measured / "halved.json")
    assert done.returncode == 0, done.stderr
    halved, plain = json.loads((measured / "halved.json").read_text()), json.loads((measured / "j.json").read_text())
    means = [report["summary"]["m_r_am2"]["mean"] for report in (halved, plain["fit"])]
    assert means[0] == pytest.approx(means[1] / 2, rel=1e-6)
    assert all(f["warnings"][-1].startswith("moment_implausible: m_r is ") for f in halved["frames"])
    assert "frame 0-1: moment_implausible: m_r is " in done.stdout
    assert not any("moment" in w for f in plain["fit"]["frames"] for w in f["warnings"])


def test_without_calibration_only_voltage_domain_quantities_are_given_and_it_says_so(measured):
    with h5py.File(measured / "j.h5") as source, h5py.File(measured / "bare.mmr", "w") as target:
        for name in ("data", "sequence"):
            source.copy(name, target)
    done = here("fit", measured / "bare.mmr", "--variant", "jewel", "--json", measured / "bare.json")
    assert done.returncode == 0, done.stderr
    report = json.loads((measured / "bare.json").read_text())
    names = {"f_nat_hz", "lambda_per_s", "tf_over_i_rad_per_s2", "phi_max_rad", "psi_start_rad"}
    assert set(report["frames"][0]["parameters"]) == names
    assert "voltage-domain" in report["notes"][0]
    assert_one_line_error(here("fit", measured / "bare.mmr"), 2, "--variant")


def test_noise_alone_is_refused_with_exit_code_3(tmp_path, measured):
    with h5py.File(measured / "j.h5") as source, h5py.File(tmp_path / "noise.h5", "w") as target:
        for name in ("sequence", "calibration", "resonator"):
            source.copy(name, target)
        shape = (1, *source["data"].shape[1:])
        target["data"] = np.random.default_rng(0).normal(0, 1e-3, shape).astype("f4")
    done = here("fit", tmp_path / "noise.h5", "--json", tmp_path / "noise.json")
    assert done.returncode == 3
    frame = json.loads((tmp_path / "noise.json").read_text())["frames"][0]
    assert (frame["verdict"], frame["parameters"]) == ("refused", {})
    assert frame["reason"]


@pytest.mark.parametrize(
    ("fixed", "word"),
    [("rodrigues_x=3", "rodrigues_x"), ("lambda_per_s=nan", "nan"), ("f_nat_hz=0", "f_nat_hz"), ("x=1", "x")],
)
def test_what_cannot_be_held_fixed_is_said_in_one_line(measured, fixed, word):
    assert_one_line_error(here("fit", measured / "j.h5", "--fix", fixed), 2, word)
    assert_one_line_error(here("fit", measured / "j.h5", "--hint", fixed), 2, word)


def test_a_file_whose_only_frame_holds_nan_is_bad_input_naming_the_sample(tmp_path, measured):
    with h5py.File(measured / "j.h5") as source, h5py.File(tmp_path / "nan.h5", "w") as target:
        for name in ("sequence", "calibration", "resonator"):
            source.copy(name, target)
        volts = source["data"][:1].copy()
        volts[0, 1, 5000] = np.nan
        target["data"] = volts
    assert_one_line_error(here("fit", tmp_path / "nan.h5"), 2, "frame 0", "channel 1", "sample 5000")


def test_clipped_volts_are_refused_whatever_the_calibration_mixes(tmp_path, measured):
    with h5py.File(measured / "j.h5") as source, h5py.File(tmp_path / "clipped.h5", "w") as target:
        for name in ("sequence", "calibration", "resonator"):
            source.copy(name, target)
        target["calibration/sensitivity"][0, 1] = 0.01
        target["calibration/sensitivity"][1, 0] = 0.013
        limit = 0.97 * np.abs(source["data"][0, 0, -20000:]).max()
        target["data"] = np.clip(source["data"][:1], -limit, limit)
    done = here("fit", tmp_path / "clipped.h5", "--json", tmp_path / "c.json")
    assert done.returncode == 3
    assert "saturated" in json.loads((tmp_path / "c.json").read_text())["frames"][0]["reason"]


def test_derived_quantities_are_added_to_the_fixed_form(tmp_path):
    (path,) = copies(tmp_path, 1)
    done = here("fit", path, *SHORT, "--derived", "--json", tmp_path / "d.json")
    assert done.returncode == 0, done.stderr
    report = json.loads((tmp_path / "d.json").read_text())
    derived = report["frames"][0]["derived"]
    assert derived["equivalent_quality_factor"] < derived["quality_factor"]
    assert derived["equivalent_quality_factor_to_infinity"] == pytest.approx(458, rel=0.2)
    assert len(report["derived"]["orientation_error"]["against_best"]["angle_rad"]) == 2
    assert any("allan" in note for note in report["derived"]["notes"])


def with_a_bad_sample(folder):
    """Both example files, the second frame of each with a NaN."""
    paths = copies(folder, 2)
    for path in paths:
        with h5py.File(path, "r+") as file:
            file["data"][1, 2, -100] = np.nan
    return paths


def test_a_sample_that_is_no_number_is_named_with_its_place_and_its_frame_can_be_left_out(tmp_path):
    path, _ = with_a_bad_sample(tmp_path)
    done = here("fit", path, *SHORT)
    assert done.returncode == 0
    said = " ".join(done.stdout.split())
    assert "frame 1: refused: not_finite: value is nan at " in said
    assert "/data[frame 1, channel 2, sample " in said
    assert "not_finite" not in here("fit", path, *SHORT, "--frames", "0").stdout
    assert_one_line_error(here("fit", path, *SHORT, "--frames", "1"), 2, "not_finite", "--frames", "`frames`")
    assert_one_line_error(here("fit", path, *SHORT, "--frames", "2"), 2, "frame 2 does not exist", "0 to 1")


def test_a_clipped_frame_is_refused_with_what_to_do(tmp_path):
    (path,) = copies(tmp_path, 1)
    recording = open_recording(path)
    volts = recording.rx_volts(0)
    volts[0] = np.clip(volts[0], -0.7 * volts[0].max(), 0.7 * volts[0].max())
    fit = fit_frame(volts, recording.sequence.rate_hz, recording.calibration, FitRequest("jewel", 0.1))
    assert fit.code is Refusal.SATURATED
    assert fit.reason.startswith("saturated: ")
    assert fit.reason.endswith(Refusal.SATURATED.value)


@pytest.mark.long
def test_an_angle_is_fitted_among_recordings(tmp_path):
    (path,), angle = copies(tmp_path, 1), pendulum(tmp_path, *swing())
    done = run("fit", path, angle, "--window", "10", "--derived", "--json", tmp_path / "all.json")
    assert done.returncode == 0, done.stderr
    recording, report = json.loads((tmp_path / "all.json").read_text())["files"]
    (frame,) = report["frames"]
    assert (report["variant"], report["notes"]) == ("thread", [])
    assert set(recording) - set(report) == {"value_sources"}  # an angle has neither a sequence nor a calibration
    assert set(report) <= set(recording)
    assert set(frame["parameters"]) == {"f_nat_hz", "lambda_per_s", "phi_max_rad", "psi_start_rad"}
    assert frame["parameters"]["lambda_per_s"]["value"] == pytest.approx(0.15, rel=0.05)
    assert frame["derived"]["quality_factor"] == pytest.approx(2 * 3.1416 / 0.15, rel=0.05)


def test_the_table_shows_what_was_fitted_and_nothing_else(tmp_path):
    shown = here("fit", pendulum(tmp_path, *swing()), "--variant", "jewel_constant_friction", "--window", "10").stdout
    assert "a / rad s⁻²" in shown
    assert "m_r" not in shown


def test_what_an_angle_has_not_is_an_error_that_says_so(tmp_path):
    angle = pendulum(tmp_path, *swing())
    assert_one_line_error(here("fit", angle, "--fix", "m_r_am2=0.01"), 2, "without calibration")
    (path,) = copies(tmp_path, 1)
    assert_one_line_error(here("fit", angle, "--calibration", path), 2, "no calibration applies")
    assert_one_line_error(here("fit", angle, "--variant", "rubber"), 2, "rubber")
    assert_one_line_error(here("slide", angle, "--frame", "1"), 2, "frame 1")
    assert_one_line_error(here("harmonics", angle), 2, "fit, slide and diagnose take an angle")
