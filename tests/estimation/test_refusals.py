"""Ugly data: refused with a reason, never an exception, never a number."""

import math

import numpy as np
import pytest

from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.goodness_of_fit.lack_of_fit import power_in_words
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.ring_down_generator import NOISE_SD, RATE_HZ, Truth, dmdt, with_noise

JEWEL = Truth(f_nat_hz=213.0, m_r_am2=0.01226, tf_over_i_rad_per_s2=1190.0, phi_max_rad=0.9, psi_start_rad=3.86)


def noisy(truth=None, seconds=0.5, seed=0):
    return with_noise(dmdt(truth or Truth(), seconds), np.random.default_rng(seed))


def refused(signal, variant="thread", window="d30", rate_hz=RATE_HZ, quantity="dmdt", **more):
    result = fit_ring_down(RingDownRecord(signal, rate_hz, quantity, **more), variant, window)
    assert result.verdict == "refused"
    assert result.parameters == {}
    assert result.covariance.size == 0
    assert result.r2 is result.nrmse is result.chi2_per_dof is result.chi2_per_dof_by_channel is None
    assert result.whiteness_by_channel is result.condition is None
    assert result.seconds > 0.0
    with pytest.raises(ValueError, match="refused"):
        result.model_signal(10, RATE_HZ)
    return result.reason.split(":")[0]


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_record_with_a_value_that_is_no_number_is_refused(bad):
    signal = noisy()
    signal[1, 4321] = bad
    assert refused(signal) == "not_finite"


def test_the_first_value_that_is_no_number_is_named_by_sample_and_channel():
    signal = noisy()
    signal[0, 5000], signal[2, 4321] = math.nan, math.inf
    result = fit_ring_down(RingDownRecord(signal, RATE_HZ, "dmdt"), "thread")
    assert result.reason.startswith("not_finite: 2 samples, the first is 4321 of channel 2;")


@pytest.mark.parametrize(
    ("power", "words"),
    [
        (0.034, "3.4 % of the signal's power"),
        (0.98, "98 % of the signal's power"),
        (0.999, "as much as the signal itself, or more,"),
        (1.6, "as much as the signal itself, or more,"),
    ],
)
def test_what_is_left_over_is_described_in_words_that_make_sense(power, words):
    assert power_in_words(power) == words


def test_pure_noise_is_refused():
    for seed in range(5):
        noise = with_noise(np.zeros((3, 30000)), np.random.default_rng(seed))
        assert refused(noise) == "no_signal"


@pytest.mark.parametrize("signal", [np.zeros((3, 20000)), np.ones((3, 20000))])
def test_a_dead_channel_set_is_refused(signal):
    assert refused(signal) == "no_signal"


@pytest.mark.parametrize("samples", [0, 1, 40, 600, 1200])
def test_a_record_of_too_few_periods_is_refused(samples):
    assert refused(noisy()[:, :samples]) in {"too_short", "no_signal"}


def test_a_window_with_a_silent_beginning_is_refused():
    signal = noisy()
    signal[:, :4000] = 0.0
    assert refused(signal, window=0.24) == "no_signal"


def test_a_window_of_too_few_periods_is_refused():
    assert refused(noisy(), window=0.01) == "too_short"


def test_a_window_that_ends_before_the_valid_samples_is_refused():
    assert refused(noisy(), window=0.1, valid_from=10000) == "too_short"


def test_a_record_at_full_scale_is_refused():
    signal = np.clip(noisy(), -3.0, 3.0)
    assert refused(signal, full_scale=3.0) == "saturated"


def test_flat_tops_are_noticed_without_knowing_the_full_scale():
    assert refused(np.clip(noisy(), -5.5, 5.5)) == "saturated"


def test_clipping_that_a_rotation_has_hidden_is_caught_by_the_residual_or_the_shape():
    mixed = np.array([[1.0, 0.1, 0.0], [-0.1, 1.0, 0.2], [0.0, 0.1, 1.0]])
    signal = mixed @ np.clip(noisy(JEWEL), -4.0, 4.0)
    result = fit_ring_down(RingDownRecord(signal, RATE_HZ, "dmdt"), "jewel")
    assert result.verdict == "refused" or any("residual_not_white" in w for w in result.warnings)


def test_sampling_below_four_times_the_frequency_is_refused():
    assert refused(noisy(seconds=2.0)[:, ::100].copy(), rate_hz=RATE_HZ / 100) == "sampling_too_slow"


@pytest.mark.parametrize("window", ["n50", "d30"])
def test_the_thread_model_is_refused_for_a_jewel_record(window):
    assert refused(noisy(JEWEL, 1.3), "thread", window) == "model_does_not_explain"


def test_a_square_wave_is_refused():
    t = np.arange(30000) / RATE_HZ
    wave = np.sign(np.sin(2 * np.pi * 215 * t)) * np.array([[5.0], [1.0], [0.2]])
    assert refused(with_noise(wave, np.random.default_rng(1))) in {"no_convergence", "model_does_not_explain"}


def test_an_oscillation_too_weak_to_be_trusted_is_refused():
    signal = with_noise(dmdt(Truth(phi_max_rad=0.05), 0.3), np.random.default_rng(2), 20 * NOISE_SD)
    assert refused(signal, window="n50") in {"amplitude_below_floor", "no_convergence"}


def test_a_jewel_beyond_90_degrees_is_refused():
    signal = noisy(JEWEL.with_(phi_max_rad=1.75), 0.5)
    assert refused(signal, "jewel") == "contact_lost"


def test_a_single_spike_does_not_turn_the_fit_over():
    signal = noisy()
    signal[0, 3000] += 20.0
    result = fit_ring_down(RingDownRecord(signal, RATE_HZ, "dmdt"), "thread")
    assert result.verdict == "good"
    assert result.parameters["f_nat_hz"].value == pytest.approx(215.5, abs=0.01)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"variant": "torsion"}, "unknown variant"),
        ({"window": "n51"}, "window"),
        ({"window": -1.0}, "positive"),
        ({"window": math.nan}, "positive"),
        ({"window": True}, "positive"),
        ({"fixed": {"tf_over_i_rad_per_s2": 1.0}}, "cannot be fixed"),
        ({"fixed": {"lambda_per_s": math.nan}}, "finite"),
        ({"noise": NoiseModel.white(np.array([1.0]), RATE_HZ)}, "noise"),
    ],
)
def test_mistakes_of_the_caller_are_errors_that_name_them(arguments, message):
    call = {"variant": "thread", "window": "n50", **arguments}
    with pytest.raises(ValueError, match=message):
        fit_ring_down(RingDownRecord(noisy(), RATE_HZ, "dmdt"), call.pop("variant"), call.pop("window"), **call)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.zeros(5), 1e4, "dmdt"), "shape"),
        ((np.zeros((2, 5)), 1e4, "dmdt"), "three world components"),
        ((np.zeros((3, 5)), 0.0, "dmdt"), "sampling_rate_hz"),
        ((np.zeros((3, 5)), 1e4, "tesla"), "quantity"),
        ((np.zeros((3, 5)), 1e4, "dmdt", 4, 3), "valid range"),
        ((np.zeros((3, 5), dtype=complex), 1e4, "dmdt"), "complex"),
        ((np.zeros((3, 5)), 1e4, "voltage", 0, None, None, 1j * np.eye(3)), "complex"),
    ],
)
def test_a_malformed_record_cannot_be_made(arguments, message):
    with pytest.raises(ValueError, match=message):
        RingDownRecord(*arguments)


def test_a_record_of_absurd_size_is_refused_without_overflow():
    assert refused(1e200 * noisy()) == "not_finite"


def test_an_oscillation_that_grows_is_refused():
    assert refused(noisy()[:, ::-1].copy()) == "out_of_range"


@pytest.mark.parametrize("variant", ["thread", "jewel"])
def test_a_record_with_one_live_channel_is_refused_as_dipole(variant):
    assert refused(noisy() * np.array([[1.0], [0.0], [0.0]]), variant) in {
        "no_convergence",
        "amplitude_below_floor",
        "model_does_not_explain",
        "out_of_range",
    }


@pytest.mark.parametrize("seed", [0, 1, *(pytest.param(s, marks=pytest.mark.long) for s in range(2, 6))])
def test_garbage_is_refused_and_never_raises(seed):
    rng = np.random.default_rng(seed)
    n = 12000
    t = np.arange(n) / RATE_HZ
    garbage = [
        np.cumsum(rng.standard_normal((3, n)), axis=1),
        np.where(t > 0.1, 5.0, 0.0) + 0.01 * rng.standard_normal((3, n)),
        np.sin(2 * np.pi * (100 * t + 2000 * t * t)) + 0.01 * rng.standard_normal((3, n)),
        np.eye(3, n, k=500),
        np.hstack([0.02 * rng.standard_normal((3, 9000)), noisy()[:, :9000]]),
        np.delete(noisy(), slice(6000, 6100), axis=1),
    ][seed]
    for variant in ("thread", "jewel"):
        for quantity in ("dmdt", "voltage"):
            result = fit_ring_down(RingDownRecord(garbage, RATE_HZ, quantity), variant)
            assert result.verdict == "refused", (variant, quantity, result)


@pytest.mark.parametrize("quantity", ["dmdt", "voltage"])
@pytest.mark.parametrize("seed", range(3))
def test_a_signal_buried_in_brown_noise_is_called_no_signal_not_a_short_record(quantity, seed):
    rng = np.random.default_rng(seed)
    signal = noisy(seconds=1.0)
    wandering = signal + np.cumsum(rng.standard_normal(signal.shape), axis=1)
    assert refused(wandering, window="d30", quantity=quantity) == "no_signal"
    assert refused(wandering, window=0.5, quantity=quantity) in {"no_signal", "too_short"}
