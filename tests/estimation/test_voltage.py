"""Raw volts without a calibration: only the motion is estimated."""

import numpy as np
import pytest
from scipy.stats import chi2

from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.ring_down_generator import NOISE_SD, RATE_HZ, Truth, dmdt, joint_chi2, random_truth, with_noise

P = np.array([[1.1e-3, 8e-6, -5e-6], [-6e-6, 1.0e-3, 9e-6], [4e-6, -7e-6, 8.8e-4], [5e-4, 5e-4, 0.0]])


def volts_of(truth, seconds, seed, channels):
    rng = np.random.default_rng(seed)
    p = P[channels]
    sd = np.abs(p).max(axis=1) * 0.02
    return with_noise(-p @ dmdt(truth, seconds), rng, sd)


@pytest.mark.parametrize("channels", [[0], [1, 2], [0, 1, 2], [0, 1, 2, 3]])
@pytest.mark.parametrize("variant", ["thread", "jewel"])
def test_any_number_of_channels_gives_the_motion(channels, variant):
    friction = 1190.0 if variant == "jewel" else 0.0
    truth = Truth(tf_over_i_rad_per_s2=friction, phi_max_rad=0.8, psi_start_rad=2.5, rodrigues=(0.3, -0.2, -1.0))
    result = fit_ring_down(RingDownRecord(volts_of(truth, 0.6, 1, channels), RATE_HZ, "voltage"), variant)
    assert result.verdict == "good", result.reason
    assert "m_r_am2" not in result.parameters
    # e_v is counted along the strongest channel; elsewhere in this file that is world x.
    miss = (result.parameters["psi_start_rad"].value - truth.psi_start_rad) % np.pi
    assert min(miss, np.pi - miss) < 5 * result.parameters["psi_start_rad"].std
    for name in ("f_nat_hz", "lambda_per_s", "phi_max_rad"):
        estimate = result.parameters[name]
        assert abs(estimate.value - truth.value(name)) < 4 * estimate.std, name


def test_the_sign_convention_makes_the_strongest_channels_sensitivity_positive():
    truth = Truth(phi_max_rad=0.5)
    result = fit_ring_down(RingDownRecord(volts_of(truth, 0.4, 2, [0, 1, 2]), RATE_HZ, "voltage"), "thread")
    assert chi2.sf(joint_chi2(result, truth), 4) > 1e-4
    gains = result.fitted.state.observation.sensitivities
    assert gains[np.argmax(np.abs(gains[:, 0])), 0] < 0.0


@pytest.mark.parametrize("variant", ["thread", "jewel"])
def test_random_motions_are_recovered_with_free_gains(variant):
    for seed in range(12):
        rng = np.random.default_rng(seed)
        truth = random_truth(rng, variant, deg_range=(8.0, 70.0)).with_(rodrigues=(0.0625, -0.0156, -1.53))
        signal = with_noise(dmdt(truth, 0.5), rng, NOISE_SD)
        result = fit_ring_down(RingDownRecord(-signal, RATE_HZ, "voltage"), variant)
        assert result.verdict == "good", f"seed {seed}: {result.reason}, {truth}"
        assert chi2.sf(joint_chi2(result, truth), len(result.covariance_names)) > 1e-4, seed


def test_free_gains_know_the_amplitude_less_well_than_a_calibration_does():
    truth = Truth(phi_max_rad=0.5)
    signal = with_noise(dmdt(truth, 0.3), np.random.default_rng(3))
    free = fit_ring_down(RingDownRecord(-signal, RATE_HZ, "voltage"), "thread", "n50")
    tied = fit_ring_down(RingDownRecord(signal, RATE_HZ, "dmdt"), "thread", "n50")
    assert free.parameters["phi_max_rad"].std > 1.3 * tied.parameters["phi_max_rad"].std
