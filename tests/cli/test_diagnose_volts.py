"""`platform-daemon diagnose` on recordings of coils that nobody calibrated: twins of the public ones."""

import json
from dataclasses import replace

import h5py
import numpy as np
import pytest

from tests.kit.command_line import assert_one_line_error, here
from tests.kit.mmr_twins import LARGE, SMALL, write_twin
from tests.kit.specimen_files import THREAD, without


def diagnosed(folder, path, *options):
    done = here("diagnose", path, "--variant", "thread", "--json", folder / "d.json", "--force", *options)
    assert done.returncode == 0, done.stderr
    return done.stdout, json.loads((folder / "d.json").read_text())


@pytest.mark.long
def test_a_hidden_drag_is_named_in_counts_of_three_coils(tmp_path):
    path = write_twin(tmp_path / "large.h5", replace(LARGE, drag_per_rad=5e-5), "<i2", frames=2, seed=3)
    text, report = diagnosed(tmp_path, path, "--html", tmp_path / "d.html")
    assert report["verdict"] == "explained"
    (named,) = report["effects"]
    assert named["id"] == "quadratic_drag"
    strength = named["strength"]
    assert abs(strength["value"] - 5e-5) < 5.0 * strength["std"] < 1e-6
    assert report["held_out"]["chi2_per_dof_after"] == pytest.approx(1.0, abs=0.03)
    assert report["held_out"]["chi2_per_dof_before"] > 5.0
    assert any("gains of the channels, their mixing, the orientation and the moment" in n for n in report["notes"])
    assert not {t["id"] for t in report["ranking"]} & {"channel_gain", "crosstalk"}
    assert "m_r" not in text


@pytest.mark.long
@pytest.mark.parametrize(
    ("dtype", "channels"),
    [("<u2", 2), *(pytest.param(*each, marks=pytest.mark.campaign) for each in ((">f4", 3), (">i4", 1)))],
)
def test_nothing_is_named_where_nothing_is_missing(tmp_path, dtype, channels):
    path = write_twin(tmp_path / "small.h5", SMALL, dtype, channels=channels, seed=channels)
    _, report = diagnosed(tmp_path, path)
    assert report["verdict"] == "nothing_missing"
    assert report["effects"] == []
    assert report["parameters_after"]["f_nat_hz"]["value"] == pytest.approx(SMALL.f_hz, rel=1e-6)
    assert report["parameters_after"]["lambda_per_s"]["value"] == pytest.approx(SMALL.loss_per_s, rel=1e-4)


@pytest.mark.parametrize("channels", [pytest.param(n, marks=pytest.mark.campaign) for n in (1, 2)])
def test_dry_friction_is_named_with_fewer_coils(tmp_path, channels):
    path = write_twin(tmp_path / "small.h5", replace(SMALL, dry_rad_per_s2=500.0), frames=2, channels=channels, seed=6)
    _, report = diagnosed(tmp_path, path)
    assert [e["id"] for e in report["effects"]] == ["coulomb_friction"]
    assert report["effects"][0]["strength"]["value"] == pytest.approx(500.0, rel=0.01)


@pytest.mark.campaign
def test_what_acts_on_one_coil_is_named_by_its_number(tmp_path):
    path = write_twin(tmp_path / "late.h5", SMALL, "<f8", seed=5)
    with h5py.File(path, "r+") as file:
        data, rate_hz = file["data"][:], SMALL.rate_hz
        turn = np.exp(-2j * np.pi * np.fft.rfftfreq(data.shape[-1], 1.0 / rate_hz) * 3e-6)
        moved = np.fft.irfft(np.fft.rfft(data[:, 1]) * turn, data.shape[-1])
        file["data"][:, 1, 200:-200] = moved[:, 200:-200]
        kept = file["data"][:, :, 200:-200]
        del file["data"]
        file["data"] = kept
    _, report = diagnosed(tmp_path, path)
    (named,) = report["effects"]
    assert named["id"] in ("channel_delay", "receive_lowpass")
    assert named["detail"]["axis"] == "channel 1"
    assert named["strength"]["value"] == pytest.approx(3e-6, rel=0.05)


@pytest.mark.long
def test_what_volts_cannot_be_is_refused_in_one_line(tmp_path):
    volts = without(tmp_path, "calibration")
    assert_one_line_error(here("diagnose", volts, "--observable", "dmdt"), 2, "no sensitivity", "--calibration")
    assert_one_line_error(here("diagnose", volts, THREAD), 2, "is calibrated", "by themselves")
    assert_one_line_error(here("diagnose", THREAD, volts), 2, "no sensitivity", "by themselves")
    one, two = (write_twin(tmp_path / f"{c}.h5", SMALL, channels=c, frames=1) for c in (1, 2))
    assert_one_line_error(here("diagnose", one, two, "--variant", "thread"), 2, "different numbers of channels")
    assert_one_line_error(here("diagnose", one), 2, "--variant")
    assert_one_line_error(here("diagnose", one, "--variant", "thread", "--calibration", THREAD), 2, "converter counts")
