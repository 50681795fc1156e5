"""Warnings name what is doubtful, and what would help."""

import re
from dataclasses import replace

import numpy as np
import pytest

from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.goodness_of_fit.collinearity import (
    CollinearLosses,
    collinearity_warning,
    separating_window_s,
)
from platform_daemon.estimation.goodness_of_fit.verdict import published_parameters, residual_left
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.parameters import Estimate
from platform_daemon.estimation.physics.models import JEWEL as JEWEL_MODEL
from platform_daemon.estimation.prepared_record import prepare_record
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.solve import find_minimum
from tests.kit.ring_down_generator import NOISE_SD, RATE_HZ, Truth, dmdt, random_truth, with_noise

JEWEL = Truth(f_nat_hz=213.25, m_r_am2=0.01226, tf_over_i_rad_per_s2=1190.0, phi_max_rad=0.93, psi_start_rad=3.86)


def warnings_of(truth, variant, seconds, scale):
    noise = NoiseModel.white(scale * NOISE_SD, RATE_HZ)
    signal = with_noise(dmdt(truth, seconds), np.random.default_rng(3), scale * NOISE_SD)
    result = fit_ring_down(RingDownRecord(signal, RATE_HZ, "dmdt"), variant, seconds, noise=noise)
    assert result.verdict == "good", result.reason
    return result.warnings


@pytest.mark.parametrize("phi_max_rad", [0.93, 0.4])
def test_losses_that_a_window_cannot_tell_apart_come_with_the_window_that_would(phi_max_rad):
    truth = JEWEL.with_(phi_max_rad=phi_max_rad)
    (warning,) = warnings_of(truth, "jewel", 0.12, 10.0)
    assert warning.startswith("lambda_tf_not_separable")
    enough = float(re.search(r"about ([\d.]+) s", warning)[1])
    assert 0.12 < enough < 0.6
    assert not any(w.startswith("lambda_tf") for w in warnings_of(truth, "jewel", enough, 10.0))


@pytest.mark.parametrize("seed", range(6))
def test_the_window_that_is_named_does_tell_the_losses_apart(seed):
    rng = np.random.default_rng(seed)
    truth = random_truth(rng, "jewel", deg_range=(15.0, 65.0))
    scale, seconds = rng.uniform(3.0, 20.0), 12.0 / truth.f_nat_hz
    signal, noise = with_noise(dmdt(truth, 3.0), rng, scale * NOISE_SD), NoiseModel.white(scale * NOISE_SD, RATE_HZ)
    record = RingDownRecord(signal, RATE_HZ, "dmdt")
    short = fit_ring_down(record, "jewel", seconds, noise=noise)
    (warning,) = [w for w in short.warnings if w.startswith("lambda_tf_not_separable")]
    enough = float(re.search(r"about ([\d.]+) s", warning)[1])
    assert seconds < enough < 20.0 * seconds
    result = fit_ring_down(record, "jewel", enough, noise=noise)
    assert not any(w.startswith("lambda_tf") for w in result.warnings)
    losses = [result.parameters[name] for name in ("lambda_per_s", "tf_over_i_rad_per_s2")]
    assert min(loss.std / abs(loss.value) for loss in losses) < 0.2


def test_losses_that_no_window_separates_are_named():
    noise = NoiseModel.white(NOISE_SD, RATE_HZ)
    record = RingDownRecord(with_noise(dmdt(JEWEL, 0.24), np.random.default_rng(3)), RATE_HZ, "dmdt")
    prepared = prepare_record(record, 0.24, noise, {})
    problem, best = find_minimum(prepared, JEWEL_MODEL)
    public, residual = published_parameters(prepared, problem, best), residual_left(prepared, problem, best)
    tangle = CollinearLosses(("tf_over_i_rad_per_s2", "lambda_per_s"), -0.999)

    def window(times):
        known = {name: Estimate(e.value, times * e.std) for name, e in public.parameters.items()}
        return separating_window_s(problem, best.state, residual, replace(public, parameters=known), tangle)

    assert window(1.0) == pytest.approx(0.24, rel=0.01)
    assert 0.3 < window(100.0) < 2.0
    # The friction stops the rotor after two seconds.
    assert window(1e5) is None
    assert "the motion ends before" in collinearity_warning(tangle, None)


def test_a_window_of_few_periods_is_called_short():
    assert any(w.startswith("window_too_short: 8") for w in warnings_of(Truth(), "thread", 0.04, 1.0))
    assert warnings_of(Truth(), "thread", 0.1, 1.0) == ()


@pytest.mark.parametrize("variant", ["thread", "jewel"])
@pytest.mark.parametrize("scale", [0.02, 1.0])
def test_a_fast_wide_swing_far_above_the_noise_leaves_a_white_residual(variant, scale):
    friction = 15000.0 if variant == "jewel" else 0.0
    truth = Truth(
        f_nat_hz=930.0, m_r_am2=0.016, lambda_per_s=1.2, phi_max_rad=1.1, psi_start_rad=0.7,
        tf_over_i_rad_per_s2=friction,
    )  # fmt: skip
    assert warnings_of(truth, variant, 0.24, scale) == ()


def test_what_a_strong_signal_hides_in_its_harmonics_is_still_reported():
    truth = Truth(f_nat_hz=930.0, m_r_am2=0.016, lambda_per_s=1.2, phi_max_rad=1.1, psi_start_rad=0.7)
    signal = dmdt(truth, 0.24)
    signal = with_noise(signal + 3e-6 * signal**2, np.random.default_rng(4), 0.02 * NOISE_SD)
    noise = NoiseModel.white(0.02 * NOISE_SD, RATE_HZ)
    result = fit_ring_down(RingDownRecord(signal, RATE_HZ, "dmdt"), "thread", 0.24, noise=noise)
    assert any("not_white" in w for w in result.warnings) or result.verdict == "refused"


@pytest.mark.long
@pytest.mark.parametrize(("frequency_hz", "periods"), [(600.0, 6.2), (600.0, 20.0), (215.0, 20.0)])
@pytest.mark.parametrize("variant", ["thread", "jewel"])
def test_a_short_clean_record_whose_own_noise_is_seen_dimly_is_called_white(frequency_hz, periods, variant):
    rng = np.random.default_rng(5)
    near = (0.99 * frequency_hz, 1.01 * frequency_hz)
    for _ in range(12):
        truth = random_truth(rng, variant, f_range=near, deg_range=(20.0, 60.0))
        seconds = periods / frequency_hz
        record = RingDownRecord(with_noise(dmdt(truth, seconds), rng), RATE_HZ, "dmdt")
        warnings = fit_ring_down(record, variant, seconds).warnings
        assert not any(w.startswith("residual_not_white") for w in warnings), warnings


def test_the_same_chi2_is_no_chance_where_the_noise_is_known():
    signal = with_noise(dmdt(Truth(), 0.24), np.random.default_rng(6), 1.1 * NOISE_SD)
    noise = NoiseModel.white(NOISE_SD, RATE_HZ)
    (warning,) = fit_ring_down(RingDownRecord(signal, RATE_HZ, "dmdt"), "thread", 0.24, noise=noise).warnings
    assert warning.startswith("residual_not_white")


@pytest.mark.parametrize("variant", ["thread", "jewel"])
@pytest.mark.parametrize("seed", range(4))
def test_the_rounding_of_a_record_without_noise_is_no_misfit(variant, seed):
    truth = random_truth(np.random.default_rng(seed), variant, deg_range=(20.0, 60.0))
    result = fit_ring_down(RingDownRecord(dmdt(truth, 0.5), RATE_HZ, "dmdt"), variant, 0.5)
    assert result.verdict == "good", result.reason
    assert result.warnings == ()
