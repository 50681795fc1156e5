"""The independent simulator's example recordings: conventions, values, errors, noise."""

import json

import h5py
import numpy as np
import pytest
from scipy.stats import chi2

from platform_daemon.estimation.calibration.apply import calibrate
from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.data import DATA
from tests.kit.ring_down_generator import Truth, errors, joint_chi2

SHOTS = [(variant, frame) for variant in ("thread", "jewel") for frame in (0, 1)]


def load(variant, frame):
    name = f"example_{variant}.mmr.h5"
    with h5py.File(DATA / name) as file:
        rate = float(file["/sequence/baseFrequency"][()]) / int(file["/sequence/decimation"][()])
        received = int(file["/sequence/numRxSamples"][()])
        volts = file["/data"][frame][:, -received:].astype(float)
        sensitivity = file["/calibration/sensitivity"][()]
    truth = json.loads((DATA / "example_truth.json").read_text())[name]
    return volts, rate, sensitivity, Truth(**truth["frames"][frame], rodrigues=tuple(truth["rodrigues"])), truth


@pytest.mark.parametrize(("variant", "frame"), SHOTS)
@pytest.mark.parametrize("window", ["n50", "d30"])
def test_an_example_shot_is_reproduced_within_its_errors(variant, frame, window):
    volts, rate, sensitivity, truth, _ = load(variant, frame)
    record = RingDownRecord(calibrate(volts, rate, sensitivity).dmdt, rate, "dmdt")
    result = fit_ring_down(record, variant, window)
    assert result.verdict == "good", result.reason
    pulls = errors(result, truth) / np.sqrt(np.diag(result.covariance))
    assert np.all(np.abs(pulls) < 3.0), dict(zip(result.covariance_names, pulls, strict=True))
    assert joint_chi2(result, truth) < chi2.ppf(0.997, len(pulls))
    # 14 600 samples of a short window know their variance to 1.2 %.
    tolerance = 0.02 if window == "d30" else 0.04
    assert np.allclose(result.chi2_per_dof_by_channel, 1.0, atol=tolerance)


@pytest.mark.parametrize(("variant", "frame"), SHOTS)
def test_the_noise_of_an_example_shot_is_found_between_the_harmonics_of_its_signal(variant, frame):
    volts, rate, sensitivity, _, truth = load(variant, frame)
    noise = estimate_noise(RingDownRecord(calibrate(volts, rate, sensitivity).dmdt, rate, "dmdt"))
    assert np.allclose(noise.sd, truth["noise_sd_am2_per_s"], rtol=0.015)


@pytest.mark.parametrize(("variant", "frame"), SHOTS)
def test_raw_volts_without_calibration_give_the_same_motion(variant, frame):
    volts, rate, _, truth, _ = load(variant, frame)
    result = fit_ring_down(RingDownRecord(volts, rate, "voltage"), variant)
    assert result.verdict == "good", result.reason
    motion = {"f_nat_hz", "lambda_per_s", "phi_max_rad", "psi_start_rad"}
    assert set(result.parameters) == motion | ({"tf_over_i_rad_per_s2"} if variant == "jewel" else set())
    assert joint_chi2(result, truth) < chi2.ppf(0.997, len(result.covariance_names))


def test_a_record_that_ends_before_30_percent_is_used_whole_and_says_so():
    volts, rate, sensitivity, _, _ = load("thread", 0)
    record = RingDownRecord(calibrate(volts, rate, sensitivity).dmdt, rate, "dmdt")
    result = fit_ring_down(record, "thread", "d30")
    assert result.samples == record.samples.shape[1]
    assert any("used whole" in note for note in result.notes)


def test_the_fitted_model_leaves_nothing_but_noise_when_drawn_over_the_record():
    volts, rate, sensitivity, _, truth = load("jewel", 0)
    dmdt = calibrate(volts, rate, sensitivity).dmdt
    result = fit_ring_down(RingDownRecord(dmdt, rate, "dmdt"), "jewel", "n50")
    model = result.model_signal(dmdt.shape[1], rate)
    assert model.shape == dmdt.shape
    inside = dmdt[:, : result.samples] - model[:, : result.samples]
    assert np.allclose(inside.std(axis=1), truth["noise_sd_am2_per_s"], rtol=0.03)
    # Past the window it is a prediction; it must still be the right oscillation.
    assert np.corrcoef(model[0, -9000:], dmdt[0, -9000:])[0, 1] > 0.99
