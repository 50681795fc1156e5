import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.sliding_window import CONSTANTS, fit_sliding
from tests.kit.ring_down_generator import RATE_HZ, Truth, dmdt, rotation, with_noise

JEWEL = Truth(f_nat_hz=213.25, m_r_am2=0.01226, tf_over_i_rad_per_s2=1190.0, phi_max_rad=0.93)
THREAD = Truth()


def record(truth, seconds, seed=0, signal=None):
    clean = dmdt(truth, seconds) if signal is None else signal
    return RingDownRecord(with_noise(clean, np.random.default_rng(seed)), RATE_HZ, "dmdt")


def constants(variant):
    return [n for n in CONSTANTS if variant == "jewel" or n != "tf_over_i_rad_per_s2"]


@pytest.mark.parametrize(("variant", "truth", "seconds"), [("jewel", JEWEL, 1.3), ("thread", THREAD, 5.0)])
def test_a_clean_ring_down_gives_flat_lines_at_the_truth(variant, truth, seconds):
    found = fit_sliding(record(truth, seconds), variant)
    for name in constants(variant):
        flat = found.flatness(name)
        assert flat.windows >= 7
        assert flat.probability > 1e-4, name
        assert abs(flat.slope_per_s) < 4 * flat.slope_sd, name
        assert abs(flat.mean - truth.value(name)) < 4 * flat.mean_sd, name


def test_a_jewel_fitted_as_a_thread_is_refused_or_doubted_in_every_window():
    found = fit_sliding(record(JEWEL, 1.3), "thread", window_s=0.13)
    refused = ["jewel reaches" in (w.fit.reason or "") for w in found.windows]
    doubted = [any("residual_not_white" in text for text in w.fit.warnings) for w in found.windows]
    assert sum(refused) > len(refused) / 2
    assert all(r or d for r, d in zip(refused, doubted, strict=True))


def with_quadratic_drag(truth, drag_per_rad, seconds):
    """dm/dt of a thread whose drag has a part -b phi'|phi'|, by an integrator of its own."""
    w = 2 * math.pi * truth.f_nat_hz
    start = (truth.phi_max_rad * math.cos(truth.psi_start_rad), -w * truth.phi_max_rad * math.sin(truth.psi_start_rad))

    def motion(t, y):
        return y[1], -2 * truth.lambda_per_s * y[1] - w * w * math.sin(y[0]) - drag_per_rad * y[1] * abs(y[1])

    times = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    phi, rate = solve_ivp(motion, (0, seconds), start, "DOP853", times, rtol=1e-8, atol=1e-8, max_step=2e-4).y
    r = rotation(truth.rodrigues)
    return truth.m_r_am2 * rate * (r[:, [1]] * np.cos(phi) - r[:, [0]] * np.sin(phi))


def test_an_undeclared_drag_bends_the_line_of_the_damping():
    signal = with_quadratic_drag(THREAD, 2e-3, 1.5)
    flat = fit_sliding(record(THREAD, 1.5, signal=signal), "thread", window_s=0.2).flatness("lambda_per_s")
    assert flat.slope_per_s < -8 * flat.slope_sd


def test_windows_lie_where_they_were_requested_and_courses_show_the_good_ones():
    found = fit_sliding(record(THREAD, 1.0), "thread", window_s=0.3, step_s=0.1)
    np.testing.assert_allclose([w.start_s for w in found.windows], 0.1 * np.arange(8), atol=1e-4)
    time, value, sd = found.course("f_nat_hz")
    np.testing.assert_allclose(time, [w.centre_s for w in found.windows])
    assert np.all(np.abs(value - THREAD.f_nat_hz) < 5 * sd)


def test_overlapping_windows_do_not_count_twice_in_the_verdict():
    overlapping = fit_sliding(record(THREAD, 1.2), "thread", window_s=0.3, step_s=0.1)
    apart = fit_sliding(record(THREAD, 1.2), "thread", window_s=0.3)
    # A step is a whole number of samples, so the last window may lie one sample further.
    assert overlapping.flatness("f_nat_hz").windows == apart.flatness("f_nat_hz").windows
    assert overlapping.flatness("f_nat_hz").mean == pytest.approx(apart.flatness("f_nat_hz").mean, abs=2e-4)


def test_silence_after_the_ring_down_is_a_gap_with_its_reason():
    found = fit_sliding(record(JEWEL, 2.0), "jewel")
    last = found.windows[-1].fit
    assert last.verdict == "refused"
    assert last.reason
    assert found.course("f_nat_hz")[0].size < len(found.windows)


def test_lambda_is_held_where_it_is_inseparable_from_the_friction_and_noted():
    short = fit_sliding(record(JEWEL, 1.3), "jewel", window_s=0.06)
    held = [w for w in short.windows if w.lambda_fixed]
    reference = short.reference.parameters["lambda_per_s"].value
    assert held
    assert all(w.fit.parameters["lambda_per_s"].value == reference for w in held if w.fit.verdict == "good")
    assert all(not w.lambda_fixed for w in fit_sliding(record(JEWEL, 1.3), "jewel", 0.06, lambda_mode="free").windows)
    assert all(w.lambda_fixed for w in fit_sliding(record(JEWEL, 1.3), "jewel", 0.2, lambda_mode="fixed").windows)
    assert not any(w.lambda_fixed for w in fit_sliding(record(THREAD, 1.3), "thread", 0.2, lambda_mode="fixed").windows)


def test_held_lambda_gives_flat_friction_with_smaller_errors():
    free = fit_sliding(record(JEWEL, 1.3), "jewel", 0.12, lambda_mode="free")
    fixed = fit_sliding(record(JEWEL, 1.3), "jewel", 0.12, lambda_mode="fixed")
    assert fixed.flatness("tf_over_i_rad_per_s2").mean_sd < 0.2 * free.flatness("tf_over_i_rad_per_s2").mean_sd
    assert fixed.flatness("tf_over_i_rad_per_s2").probability > 1e-4


@pytest.mark.parametrize("lengths", [(0.0, None), (-1.0, None), (3.0, None), (0.2, 0.0), (math.nan, None), (0.2, 9.0)])
def test_lengths_that_make_no_windows_are_refused(lengths):
    with pytest.raises(ValueError, match="within"):
        fit_sliding(record(THREAD, 1.0), "thread", *lengths)


def test_noise_alone_has_no_automatic_window_but_given_ones_are_gaps():
    silent = RingDownRecord(np.random.default_rng(0).standard_normal((3, 60_000)), RATE_HZ, "dmdt")
    with pytest.raises(ValueError, match="refused"):
        fit_sliding(silent, "thread")
    assert {w.fit.verdict for w in fit_sliding(silent, "thread", 0.3).windows} == {"refused"}
