"""A loss known from elsewhere is used where the window cannot tell it, and only there; the result says so."""

import numpy as np
import pytest

from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.ring_down_generator import NOISE_SD, RATE_HZ, Truth, dmdt, errors, with_noise

JEWEL = Truth(f_nat_hz=213.25, m_r_am2=0.01226, tf_over_i_rad_per_s2=1190.0, phi_max_rad=0.93, psi_start_rad=3.86)
KNOWN = {"lambda_per_s": JEWEL.lambda_per_s}


def fit(seconds, truth=JEWEL, variant="jewel", **more):
    noise = NoiseModel.white(10.0 * NOISE_SD, RATE_HZ)
    signal = with_noise(dmdt(truth, seconds), np.random.default_rng(3), 10.0 * NOISE_SD)
    return fit_ring_down(RingDownRecord(signal, RATE_HZ, "dmdt"), variant, seconds, noise=noise, **more)


def test_a_hint_holds_lambda_in_a_window_that_cannot_tell_it_from_the_friction():
    free, hinted = fit(0.12), fit(0.12, hold_if_inseparable=KNOWN)
    assert set(free.inseparable) == {"tf_over_i_rad_per_s2", "lambda_per_s"}
    assert free.parameters["lambda_per_s"].std > 0
    assert (hinted.parameters["lambda_per_s"].value, hinted.parameters["lambda_per_s"].std) == (0.2465, None)
    assert "lambda_per_s" not in hinted.covariance_names
    assert any(note.startswith("hint used: lambda_per_s held at 0.2465") for note in hinted.notes)
    assert not any(w.startswith("lambda_tf_not_separable") for w in hinted.warnings)
    miss = errors(hinted, JEWEL)
    assert miss @ np.linalg.solve(hinted.covariance, miss) < 30.0
    tf = "tf_over_i_rad_per_s2"
    assert hinted.parameters[tf].std < 0.1 * free.parameters[tf].std


def test_a_hint_is_not_used_where_the_window_separates_both():
    free, hinted = fit(0.6), fit(0.6, hold_if_inseparable={"lambda_per_s": 5.0})
    assert hinted.parameters == free.parameters
    assert hinted.notes == free.notes


def test_without_a_hint_for_them_the_losses_stay_free_and_the_warning_stays():
    assert any(w.startswith("lambda_tf_not_separable") for w in fit(0.12).warnings)
    held = fit(0.12, fixed=KNOWN, hold_if_inseparable={"tf_over_i_rad_per_s2": 1.0})
    assert held.parameters["tf_over_i_rad_per_s2"].std is not None


def test_a_thread_has_one_loss_only_and_needs_no_hint():
    truth = JEWEL.with_(tf_over_i_rad_per_s2=0.0)
    assert (
        fit(0.12, truth, "thread", hold_if_inseparable={"lambda_per_s": 9.0}).parameters
        == fit(0.12, truth, "thread").parameters
    )


@pytest.mark.parametrize("values", [{"m_r_am2": 0.01}, {"nonsense": 1.0}, {"lambda_per_s": float("nan")}])
def test_values_that_cannot_be_held_are_errors_that_name_them(values):
    with pytest.raises(ValueError, match=next(iter(values))):
        fit(0.12, hold_if_inseparable=values)
