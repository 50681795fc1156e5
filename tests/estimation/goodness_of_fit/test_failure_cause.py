"""A record that no fit gets through, or the wrong one, is refused with the cause, not with the fit's own trouble."""

import numpy as np
import pytest

from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.ring_down_generator import NOISE_SD, RATE_HZ, Truth, dmdt, random_truth, with_noise

THREAD = Truth()
JEWEL = Truth(f_nat_hz=213.0, m_r_am2=0.01226, tf_over_i_rad_per_s2=1190.0, phi_max_rad=0.9, psi_start_rad=3.86)
TRUTHS = {"thread": THREAD, "jewel": JEWEL}
SECONDS = 0.4
MIXING = np.array([[1.0, 0.1, 0.0], [-0.1, 1.0, 0.2], [0.0, 0.1, 1.0]])


def fit(signal, variant, scale=1.0, seed=0, window=None, **more):
    noisy = with_noise(signal, np.random.default_rng(seed), scale * NOISE_SD)
    window = signal.shape[1] / RATE_HZ if window is None else window
    return fit_ring_down(RingDownRecord(noisy, RATE_HZ, "dmdt"), variant, window, **more)


def code(result):
    return "good" if result.verdict == "good" else result.reason.split(":")[0]


def names(result):
    return {w.split(":")[0] for w in result.warnings}


def compressed(signal, at_peak, mixing):
    """The signal behind a receiver whose output is so much too small at the largest of all peaks."""
    from scipy.optimize import brentq

    x = brentq(lambda x: np.tanh(x) / x - 1.0 + at_peak, 1e-6, 50.0)
    volts = mixing @ signal
    limit = np.abs(volts).max() / x
    return np.linalg.solve(mixing, limit * np.tanh(volts / limit))


@pytest.mark.parametrize("variant", ["thread", "jewel"])
@pytest.mark.parametrize("at_peak", [0.1, 0.4])
@pytest.mark.parametrize("mixing", [np.eye(3), MIXING])
def test_a_receiver_that_compresses_is_called_saturated(variant, at_peak, mixing):
    result = fit(compressed(dmdt(TRUTHS[variant], SECONDS), at_peak, mixing), variant)
    assert code(result) == "saturated", result.reason
    assert "behind the motion" in result.reason or "stays at" in result.reason


@pytest.mark.parametrize("variant", ["thread", "jewel"])
def test_a_little_compression_passes_with_a_warning_that_says_how_much(variant):
    result = fit(compressed(dmdt(TRUTHS[variant], SECONDS), 0.045, np.eye(3)), variant)
    assert code(result) == "good", result.reason
    (warning,) = [w for w in result.warnings if w.startswith("saturated")]
    assert 3.5 < float(warning.split("falls ")[1].split(" %")[0]) < 5.5
    assert "residual_not_white" in names(result)


@pytest.mark.long
@pytest.mark.parametrize("variant", ["thread", "jewel"])
@pytest.mark.parametrize("size", [0.05, 0.1])
@pytest.mark.parametrize("shift_hz", [-20.0, 10.0])
@pytest.mark.parametrize("seed", range(2))
def test_a_second_resonator_is_named_whatever_its_size_pose_and_phase(variant, size, shift_hz, seed):
    of = TRUTHS[variant]
    pose = random_truth(np.random.default_rng(seed), variant)
    turned = {"rodrigues": pose.rodrigues} if seed else {}
    other = of.with_(
        f_nat_hz=of.f_nat_hz + shift_hz, m_r_am2=size * of.m_r_am2, psi_start_rad=pose.psi_start_rad, **turned
    )
    result = fit(dmdt(of, SECONDS) + dmdt(other, SECONDS), variant, seed=seed)
    if code(result) == "good":  # the same axis, a size below 5 %
        assert "side_mode" in names(result) or "residual_not_white" in names(result)
        assert result.parameters["m_r_am2"].value == pytest.approx(of.m_r_am2, rel=0.05)
    else:
        assert code(result) == "two_resonators", result.reason


@pytest.mark.parametrize("variant", ["thread", "jewel"])
@pytest.mark.parametrize("shift_hz", [0.5, -5.0])
@pytest.mark.parametrize("seed", range(2))
def test_a_slow_beat_never_ends_in_the_fit_s_own_trouble(variant, shift_hz, seed):
    of = TRUTHS[variant]
    pose = random_truth(np.random.default_rng(seed), variant)
    other = of.with_(
        f_nat_hz=of.f_nat_hz + shift_hz,
        m_r_am2=0.1 * of.m_r_am2,
        psi_start_rad=pose.psi_start_rad,
        rodrigues=pose.rodrigues,
    )
    result = fit(dmdt(of, SECONDS) + dmdt(other, SECONDS), variant, seed=seed)
    assert code(result) in {"good", "two_resonators", "model_does_not_explain"}, result.reason
    assert code(result) != "good" or "residual_not_white" in names(result)


@pytest.mark.parametrize("variant", ["undamped", "undamped_small_angle"])
@pytest.mark.parametrize("of", ["thread", "jewel"])
def test_a_variant_without_losses_cannot_explain_a_record_that_decays(variant, of):
    result = fit(dmdt(TRUTHS[of], 1.0), variant)
    assert code(result) == "model_does_not_explain", result.reason
    assert variant in result.reason


def test_a_variant_without_losses_is_right_for_a_record_that_does_not_decay():
    result = fit(dmdt(THREAD.with_(lambda_per_s=0.0), SECONDS), "undamped")
    assert code(result) == "good", result.reason
    assert result.parameters["f_nat_hz"].value == pytest.approx(THREAD.f_nat_hz, abs=0.01)


@pytest.mark.parametrize("seconds", [0.24, 1.28])
@pytest.mark.parametrize("scale", [10.0, 30.0])
@pytest.mark.parametrize("own_noise", [True, False])
def test_noise_does_not_hide_that_a_jewel_is_no_thread(seconds, scale, own_noise):
    noise = None if own_noise else NoiseModel.white(scale * NOISE_SD, RATE_HZ)
    result = fit(dmdt(JEWEL, seconds), "thread", scale, noise=noise)
    assert code(result) == "model_does_not_explain", result.warnings
    assert "jewel" in result.reason


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("own_noise", [True, False])
def test_a_noisy_thread_is_not_taken_for_a_jewel(seed, own_noise):
    truth = random_truth(np.random.default_rng(seed), "thread", deg_range=(20.0, 60.0))
    noise = None if own_noise else NoiseModel.white(30.0 * NOISE_SD, RATE_HZ)
    result = fit(dmdt(truth, SECONDS), "thread", 30.0, seed, noise=noise)
    assert code(result) in {"good", "amplitude_below_floor"}, result.reason
    assert "other_variant" not in names(result)


@pytest.mark.parametrize("hum", [0.0, 0.4])
def test_hum_neither_hides_nor_makes_another_variant(hum):
    tone = hum * np.sin(2 * np.pi * 50.0 * np.arange(round(SECONDS * RATE_HZ)) / RATE_HZ)
    assert code(fit(dmdt(JEWEL, SECONDS) + tone, "thread")) == "model_does_not_explain"
    right = fit(dmdt(THREAD, SECONDS) + tone, "thread")
    assert (code(right), "other_variant" in names(right)) == ("good", False)


@pytest.mark.parametrize(
    ("of", "variant"),
    [
        ("thread", "thread_small_angle"),
        ("thread", "jewel_small_angle"),
        ("jewel", "thread_small_angle"),
        ("jewel", "jewel_small_angle"),
        ("jewel", "thread"),
    ],
)
@pytest.mark.parametrize("seconds", [0.1, 0.24])
@pytest.mark.parametrize("seed", range(2))
def test_a_variant_that_another_one_shows_to_be_wrong_is_refused_and_the_other_one_named(of, variant, seconds, seed):
    truth = random_truth(np.random.default_rng(seed), of, f_range=(200.0, 350.0), deg_range=(30.0, 45.0))
    result = fit(dmdt(truth, seconds), variant, seed=seed)
    assert code(result) == "model_does_not_explain", (result.parameters, result.warnings)
    assert "reaches" in result.reason or "left over" in result.reason


@pytest.mark.parametrize("seed", range(3))
def test_friction_taken_for_constant_is_refused_once_the_window_shows_it(seed):
    truth = random_truth(np.random.default_rng(seed), "jewel", deg_range=(45.0, 65.0))
    result = fit(dmdt(truth, 1.0), "jewel_constant_friction", seed=seed, window="d30")
    assert code(result) == "model_does_not_explain", (result.parameters, result.warnings)
    assert "lambda_per_s" in result.reason


def test_friction_whose_law_a_short_window_cannot_tell_is_never_fitted_in_silence():
    result = fit(dmdt(JEWEL.with_(phi_max_rad=0.6), 0.24), "jewel_constant_friction", 1.0)
    lam = result.parameters["lambda_per_s"].value if code(result) == "good" else JEWEL.lambda_per_s
    assert abs(lam / JEWEL.lambda_per_s - 1.0) < 0.1 or "other_variant" in names(result)


@pytest.mark.parametrize("strength", [3.0, 10.0])
@pytest.mark.parametrize("seed", range(2))
def test_a_thread_with_a_little_friction_passes_with_a_warning_at_most(strength, seed):
    truth = random_truth(np.random.default_rng(seed), "thread", f_range=(150.0, 250.0), deg_range=(20.0, 40.0))
    result = fit(dmdt(truth.with_(tf_over_i_rad_per_s2=strength), 1.5), "thread", seed=seed)
    assert code(result) == "good", result.reason


@pytest.mark.parametrize("seed", range(4))
def test_hum_near_the_resonance_makes_no_other_variant(seed):
    tone = 0.15 * np.sin(2 * np.pi * 200.0 * np.arange(round(0.24 * RATE_HZ)) / RATE_HZ + seed)
    result = fit(dmdt(THREAD, 0.24) + tone, "thread", seed=seed)
    assert code(result) == "good", result.reason
    assert "other_variant" not in names(result)


@pytest.mark.parametrize("degrees", [95.0, 108.0, 120.0, 135.0])
@pytest.mark.parametrize("window", [0.1, 0.24, "d30"])
def test_a_jewel_beyond_its_contact_is_refused_for_that_however_far_beyond(degrees, window):
    truth = random_truth(np.random.default_rng(int(degrees)), "jewel").with_(phi_max_rad=np.radians(degrees))
    result = fit(dmdt(truth, 0.6), "jewel", window=window)
    assert code(result) == "contact_lost", result.reason


@pytest.mark.parametrize("degrees", [60.0, 82.0])
@pytest.mark.parametrize("kind", ["clipped", "glued"])
def test_what_spoils_a_jewel_below_90_degrees_is_not_called_lost_contact(degrees, kind):
    clean = dmdt(JEWEL.with_(phi_max_rad=np.radians(degrees)), SECONDS)
    half = clean.shape[1] // 2
    spoiled = {
        "clipped": MIXING @ np.clip(clean, -3.0, 3.0),
        "glued": np.hstack([clean[:, :half], clean[:, :half]]),
    }[kind]
    assert code(fit(spoiled, "jewel")) not in {"good", "contact_lost"}
