"""The command line as a user meets it: processes, exit codes, files."""

import contextlib
import io
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import httpx2
import numpy as np
import pytest

from platform_daemon.cli.main import main

COMMAND = Path(sys.executable).with_name("platform-daemon")
DATA = Path(__file__).parents[1] / "data"
QUICK = ("--resonator", "jewel", "--rx-s", "0.6")


def run(*arguments, cwd=None, timeout=120):
    command = [COMMAND, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd, timeout=timeout, check=False)


def here(*arguments):
    """Like `run`, in this process: a new one would cost seconds."""
    out, errors, before = io.StringIO(), io.StringIO(), sys.argv
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    sys.argv = ["platform-daemon", *map(str, arguments)]
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors), pytest.raises(SystemExit) as end:
            main()
    finally:
        sys.argv = before
        for number, handler in handlers.items():
            signal.signal(number, handler)
    return subprocess.CompletedProcess(sys.argv, end.value.code or 0, out.getvalue(), errors.getvalue())


def assert_one_line_error(done, code, *words):
    assert done.returncode == code, done
    lines = [line for line in done.stderr.splitlines() if line.strip()]
    assert lines[-1].startswith("error: "), done.stderr
    assert "Traceback" not in done.stderr
    for word in words:
        assert word in lines[-1]


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    folder = tmp_path_factory.mktemp("measured")
    arguments = ("--shots", 2, "--out", folder / "j.h5", "--json", folder / "j.json", "--sample", "S", "--comment", "c")
    done = run("measure", *QUICK, *arguments)
    assert done.returncode == 0, done.stderr
    return folder


def test_measure_writes_a_recording_and_its_fits(measured):
    report = json.loads((measured / "j.json").read_text())
    assert report["shots"] == 2
    assert [f["verdict"] for f in report["fit"]["frames"]] == ["good", "good"]


def test_measure_takes_a_sequence_file(tmp_path):
    preset = (Path(__file__).parents[2] / "config" / "sequences" / "jewel.toml").read_text()
    (tmp_path / "s.toml").write_text(preset.replace("490e-6", "300e-6").replace("rx_s = 2.0", "rx_s = 0.4"))
    done = run("measure", "--resonator", "jewel", "--sequence", tmp_path / "s.toml", "--out", tmp_path / "a.h5")
    assert done.returncode == 0, done.stderr
    with h5py.File(tmp_path / "a.h5") as file:
        assert file["excitation/field"][0] == pytest.approx(300e-6)
        assert file["sequence/numRxSamples"][()] == round(0.4 * 125e6 / 2048)


def test_measure_never_overwrites_without_force(measured):
    before = (measured / "j.h5").read_bytes()
    assert_one_line_error(here("measure", *QUICK, "--out", measured / "j.h5"), 2, "j.h5", "--force")
    assert (measured / "j.h5").read_bytes() == before


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


def test_fit_of_several_files_nests_them(measured):
    done = here("fit", measured / "j.h5", DATA / "example_thread.mmr.h5", "--json", measured / "both.json")
    assert done.returncode == 0, done.stderr
    files = json.loads((measured / "both.json").read_text())["files"]
    assert [f["variant"] for f in files] == ["jewel", "thread"]


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
    halved = json.loads((measured / "halved.json").read_text())["summary"]["m_r_am2"]["mean"]
    plain = json.loads((measured / "j.json").read_text())["fit"]["summary"]["m_r_am2"]["mean"]
    assert halved == pytest.approx(plain / 2, rel=1e-6)


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


def test_predict_gives_the_bound_for_each_window(tmp_path):
    done = here("predict", "--resonator", "thread", "--window", "n50", "--window", "4.9", "--json", tmp_path / "p.json")
    assert done.returncode == 0, done.stderr
    short, long = json.loads((tmp_path / "p.json").read_text())["windows"]
    assert short["std"]["f_nat_hz"] == pytest.approx(0.0008, rel=0.15)
    assert long["std"]["f_nat_hz"] == pytest.approx(1.7e-5, rel=0.1)


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


def test_plot_writes_a_png_and_info_says_what_the_file_holds(measured):
    done = run("plot", measured / "j.h5", "--frame", 1)
    assert done.returncode == 0, done.stderr
    assert (measured / "j-frame1.png").read_bytes().startswith(b"\x89PNG")
    assert_one_line_error(here("plot", measured / "j.h5", "--frame", 1), 2, "--force")
    assert_one_line_error(here("plot", measured / "j.h5", "--frame", 7), 2, "frame 7")
    assert "jewel" in here("info", measured / "j.h5").stdout


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


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("fit", "missing.h5"), "missing.h5"),
        (("info", "missing.h5"), "missing.h5"),
        (("plot", "."), "directory"),
        (("measure", "--resonator", "spring", "--out", "x.h5"), "spring"),
        (("measure", *QUICK, "--out", "nowhere/x.h5"), "nowhere"),
        (("measure", *QUICK, "--out", "x.h5", "--field-ut", "5000"), "field"),
        (("measure", *QUICK, "--out", "x.h5", "--window", "d40"), "d40"),
        (("measure", *QUICK, "--out", "x.h5", "--set", "limits.max_field=1"), "max_field"),
        (("measure", "--resonator", "jewel", "--rx-s", "0", "--out", "x.h5"), "rx_s"),
        (("measure", *QUICK, "--out", "x.h5", "--platform", "nothing"), "nothing"),
        (("config", "check", "missing.toml"), "missing.toml"),
        (("fit",), "Missing argument"),
        (("predict", "--resonator", "thread", "--noise", "0,1"), "noise"),
        (("predict", "--resonator", "thread", "--deflection-deg", "95"), "deflection"),
        (("nonsense",), "nonsense"),
        (("measure", *QUICK, "--out", "x.h5", "--shots", "-1"), "--shots"),
        (("measure", *QUICK, "--out", "x.h5", "--shots", "0"), "shots"),
        (("measure", *QUICK, "--out", "x.h5", "--sequence", "missing.toml"), "missing.toml"),
    ],
)
def test_bad_input_is_one_line_with_exit_code_2_and_leaves_nothing_behind(tmp_path, monkeypatch, arguments, word):
    monkeypatch.chdir(tmp_path)
    assert_one_line_error(here(*arguments), 2, word)
    assert list(tmp_path.iterdir()) == []


def test_the_process_itself_ends_with_exit_code_2(tmp_path):
    assert_one_line_error(run("measure", "--resonator", "spring", "--out", "s.h5", cwd=tmp_path), 2, "spring")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_measure_keeps_its_finished_shots(tmp_path, number):
    command = [COMMAND, "measure", *QUICK, "--shots", "500", "--out", tmp_path / "a.h5"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    wait_for(lambda: list(tmp_path.glob(".*/shot_000002.h5")))
    process.send_signal(number)
    said, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "of 500 shots in" in said
    assert "outputs are off" in errors
    with h5py.File(tmp_path / "a.h5") as file:
        assert file["data"].shape[0] >= 2


def test_shots_of_a_killed_measure_are_recovered_by_the_next(tmp_path):
    command = [COMMAND, "measure", *QUICK, "--shots", "500", "--out", tmp_path / "a.h5"]
    process = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    wait_for(lambda: list(tmp_path.glob(".*/shot_000002.h5")))
    process.kill()
    process.wait()
    shots = len(list(tmp_path.glob(".*/shot_??????.h5")))
    done = run("measure", *QUICK, "--out", tmp_path / "a.h5", "--force")
    assert done.returncode == 0, done.stderr
    with h5py.File(tmp_path / "a.recovered.h5") as file:
        assert file["data"].shape[0] == shots


def test_the_server_answers_and_leaves_cleanly_on_sigterm(tmp_path):
    command = [COMMAND, "serve", "--port", "0", "--data", tmp_path / "data"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    address = process.stdout.readline().split()[-1]
    assert httpx2.get(f"{address}/health").json()["status"] == "ok"
    second = run("serve", "--port", "0", "--data", tmp_path / "data")
    assert_one_line_error(second, 2, "another daemon")
    taken = run("serve", "--port", address.rsplit(":")[-1], "--data", tmp_path / "other")
    assert_one_line_error(taken, 2, "cannot listen")
    process.send_signal(signal.SIGTERM)
    assert process.wait(timeout=30) == 0


def wait_for(condition, timeout=60):
    deadline = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_the_package_runs_from_any_folder(tmp_path):
    done = run("--version", cwd=tmp_path)
    assert done.returncode == 0
    assert done.stdout.strip() == "0.1.0"
    assert os.listdir(tmp_path) == []


def test_reset_amplifier_says_what_it_found():
    done = run("reset-amplifier")
    assert done.returncode == 0, done.stderr
    assert done.stdout == "no fault was latched; the amplifier is disabled and muted\n"
