"""Two resonators in one record are refused by name, with both frequencies; what only resembles them is not."""

import math
import re

import numpy as np
import pytest

from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.screening.separate_lines import find_far_lines
from tests.kit.ring_down_generator import RATE_HZ, Truth, dmdt, random_truth, with_noise

THREAD = Truth()
JEWEL = Truth(f_nat_hz=213.0, m_r_am2=0.01226, tf_over_i_rad_per_s2=1190.0, phi_max_rad=0.9, psi_start_rad=3.86)
SECONDS = 0.4


def fit(signal, variant="thread", seed=0):
    noisy = with_noise(signal, np.random.default_rng(seed))
    return fit_ring_down(RingDownRecord(noisy, RATE_HZ, "dmdt"), variant, signal.shape[1] / RATE_HZ)


def companion(of, size, shift_hz, **changes):
    return of.with_(f_nat_hz=of.f_nat_hz + shift_hz, m_r_am2=size * of.m_r_am2, **changes)


def frequencies(reason):
    return [float(f) for f in re.findall(r"([\d.]+) Hz", reason)[:2]]


@pytest.mark.parametrize("size", [0.06, pytest.param(0.3, marks=pytest.mark.campaign), 1.0])
@pytest.mark.parametrize("shift_hz", [-40.0, 5.0, 10.0, 65.0])
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.long)])
def test_a_second_thread_of_any_axis_is_refused_with_both_frequencies(size, shift_hz, seed):
    any_pose = random_truth(np.random.default_rng(seed), "thread")
    # Where the axes agree there is no second direction, so let them differ.
    other = companion(
        THREAD, size, shift_hz, rodrigues=any_pose.rodrigues, psi_start_rad=any_pose.psi_start_rad, lambda_per_s=0.32
    )
    result = fit(dmdt(THREAD, SECONDS) + dmdt(other, SECONDS), seed=seed)
    assert result.verdict == "refused"
    assert result.reason.startswith("two_resonators"), result.reason
    slowing = 1 - THREAD.phi_max_rad**2 / 16
    expected = sorted([slowing * THREAD.f_nat_hz, slowing * other.f_nat_hz])
    assert sorted(frequencies(result.reason)) == pytest.approx(expected, abs=2.0)


@pytest.mark.parametrize("size", [0.3, 1.0])
def test_the_same_axis_and_phase_do_not_hide_a_second_thread(size):
    result = fit(dmdt(THREAD, SECONDS) + dmdt(companion(THREAD, size, 10.0), SECONDS))
    assert result.reason.startswith("two_resonators"), result.reason


@pytest.mark.parametrize("size", [0.15, *(pytest.param(s, marks=pytest.mark.long) for s in (0.5, 1.0))])
@pytest.mark.parametrize("shift_hz", [-3.0, 30.0])
def test_a_second_jewel_is_refused(size, shift_hz):
    other = companion(JEWEL, size, shift_hz, phi_max_rad=0.5, psi_start_rad=1.0, rodrigues=(0.3, 0.2, 0.1))
    assert fit(dmdt(JEWEL, SECONDS) + dmdt(other, SECONDS), "jewel").reason.startswith("two_resonators")


@pytest.mark.parametrize(("of", "variant"), [(THREAD, "thread"), (JEWEL, "jewel")])
def test_a_small_side_mode_passes_with_a_warning_and_hardly_moves_the_numbers(of, variant):
    side = companion(of, 0.01, 40.0, rodrigues=(0.3, 0.2, 0.1))
    result = fit(dmdt(of, SECONDS) + dmdt(side, SECONDS), variant)
    assert result.verdict == "good", result.reason
    assert any(w.startswith("side_mode") for w in result.warnings)
    assert any(w.startswith("residual_not_white") for w in result.warnings)
    assert result.parameters["m_r_am2"].value == pytest.approx(of.m_r_am2, rel=0.01)
    assert min(result.whiteness_by_channel) < 0.9


@pytest.mark.parametrize("frequency_hz", [50.0, 333.0])
def test_a_steady_tone_is_no_second_resonator(frequency_hz):
    clean = dmdt(THREAD, SECONDS)
    tone = 0.4 * np.sin(2 * math.pi * frequency_hz * np.arange(clean.shape[1]) / RATE_HZ)
    result = fit(clean + tone)
    assert result.verdict == "good", result.reason
    assert result.parameters["m_r_am2"].value == pytest.approx(THREAD.m_r_am2, rel=0.01)


@pytest.mark.parametrize("kind", ["gap", "jump", "glued", "repeated"])
@pytest.mark.parametrize(("of", "variant"), [(THREAD, "thread"), (JEWEL, "jewel")])
def test_a_broken_record_is_not_called_two_resonators_and_never_passes_in_silence(kind, of, variant):
    clean = dmdt(of, SECONDS)
    middle = clean.shape[1] // 2
    broken = {
        "gap": np.delete(clean, slice(middle, middle + 40), axis=1),
        "jump": np.hstack([clean[:, :middle], 1.2 * clean[:, middle:]]),
        "glued": np.hstack([clean[:, :middle], clean[:, :middle]]),
        "repeated": np.hstack([clean[:, :middle], clean[:, middle - 500 :]]),
    }[kind]
    result = fit(broken, variant)
    if result.verdict == "good":
        assert any(w.startswith("residual_not_white") for w in result.warnings)
    else:
        assert not result.reason.startswith("two_resonators")


@pytest.mark.parametrize("seed", [0, 1, *(pytest.param(s, marks=pytest.mark.long) for s in range(2, 8))])
@pytest.mark.parametrize("variant", ["thread", "jewel"])
def test_a_single_resonator_is_white_and_raises_no_doubt(seed, variant):
    truth = random_truth(np.random.default_rng(seed), variant)
    result = fit(dmdt(truth, SECONDS), variant, seed)
    assert result.verdict == "good", result.reason
    assert not any(w.startswith(("residual", "side_mode", "steady_tone")) for w in result.warnings), result.warnings
    assert min(result.whiteness_by_channel) > 0.8
    assert result.condition >= 1.0


def turned(of, ratio, size, **changes):
    """A resonator about another axis, at a multiple of the frequency, whose dm/dt has this share of the first one's."""
    f = ratio * of.f_nat_hz
    m_r = size * of.m_r_am2 * of.phi_max_rad / (ratio * 0.3)
    more = {"rodrigues": (1.1, -0.4, 0.7), "phi_max_rad": 0.3, "psi_start_rad": 2.0, "tf_over_i_rad_per_s2": 0.0}
    return of.with_(f_nat_hz=f, m_r_am2=m_r, **{**more, "lambda_per_s": 0.3, **changes})


@pytest.mark.parametrize(("of", "variant"), [(THREAD, "thread"), (JEWEL, "jewel")])
@pytest.mark.parametrize(
    "ratio", [0.3, 1.95, 3.53, *(pytest.param(r, marks=pytest.mark.campaign) for r in (2.97, 4.19, 5.4))]
)
@pytest.mark.parametrize("size", [0.06, 0.2])
def test_a_second_resonator_is_refused_with_its_size_near_harmonics_and_far_above_them(of, variant, ratio, size):
    result = fit(dmdt(of, 0.24) + dmdt(turned(of, ratio, size), 0.24), variant)
    assert result.reason.startswith("two_resonators"), result.reason
    assert any(f == pytest.approx(ratio * of.f_nat_hz, rel=0.01) for f in frequencies(result.reason))
    reported = float(re.search(r"with ([\d.e+]+) %", result.reason)[1])
    assert reported == pytest.approx(100.0 * size, rel=0.15)


def test_a_second_resonator_that_takes_most_of_the_power_is_refused_by_name():
    result = fit(dmdt(THREAD, 0.24) + dmdt(turned(THREAD, 4.19, 0.6), 0.24))
    assert result.reason.startswith("two_resonators"), result.reason


@pytest.mark.parametrize(("of", "variant"), [(THREAD, "thread"), (JEWEL, "jewel")])
def test_with_a_side_mode_the_warning_says_what_the_losses_really_are(of, variant):
    result = fit(dmdt(of, 0.24) + dmdt(turned(of, 1.01, 0.006), 0.24), variant)
    assert result.verdict == "good", result.reason
    (warning,) = [w for w in result.warnings if w.startswith("side_mode")]
    reported = dict(re.findall(r"beside it (\w+) is ([-\d.e+]+)", warning))
    losses = [n for n in ("lambda_per_s", "tf_over_i_rad_per_s2") if n in result.parameters]
    assert sorted(reported) == sorted(losses)
    for name in losses:
        estimate, truth = result.parameters[name], of.value(name)
        assert abs(estimate.value - truth) > 5.0 * estimate.std
        assert abs(float(reported[name]) - truth) < 0.2 * abs(estimate.value - truth)


def test_a_side_mode_that_moves_a_loss_by_more_than_half_is_refused():
    result = fit(dmdt(JEWEL, 0.24) + dmdt(turned(JEWEL, 0.98, 0.02, psi_start_rad=0.5), 0.24), "jewel")
    assert result.reason.startswith("two_resonators"), result.reason
    assert "beside it lambda_per_s moves by" in result.reason


@pytest.mark.parametrize("pole_s", [1e-4, 4e-4])
def test_harmonics_that_a_slow_receiver_changes_are_no_second_resonator(pole_s):
    result = fit(dmdt(THREAD, 0.24, pole_s=pole_s, lead_s=0.01))
    assert result.verdict == "good", result.reason
    assert not any(w.startswith("side_mode") for w in result.warnings), result.warnings


def test_a_second_resonator_that_passes_for_noise_is_refused_all_the_same():
    """Far below the fundamental, in a short record without blank shots, its leakage is a colour of the noise."""
    result = fit(dmdt(JEWEL, 0.24) + dmdt(turned(JEWEL, 0.315, 0.1), 0.24), "jewel")
    assert result.reason.startswith("two_resonators"), result.reason


POSE = random_truth(np.random.default_rng(3), "thread").rodrigues
OTHER = THREAD.with_(lambda_per_s=0.3, psi_start_rad=2.0, rodrigues=POSE)


def test_a_beat_that_ends_the_window_early_is_named_not_the_short_window():
    for shift_hz in (12.0, 15.0, 18.0):
        clean = dmdt(THREAD, 1.0) + dmdt(OTHER.with_(f_nat_hz=THREAD.f_nat_hz + shift_hz), 1.0)
        record = RingDownRecord(with_noise(clean, np.random.default_rng(1)), RATE_HZ, "dmdt")
        result = fit_ring_down(record, "thread", "d30")
        assert result.reason.startswith("two_resonators"), result.reason
        assert abs(np.subtract(*frequencies(result.reason))) == pytest.approx(shift_hz, abs=2.0)


@pytest.mark.parametrize("frequency_hz", [385.0, 400.0])
@pytest.mark.parametrize("window", [0.24, "d30"])
def test_a_second_resonator_far_away_is_named_where_no_fit_gets_through(frequency_hz, window):
    clean = dmdt(THREAD, 1.0) + dmdt(OTHER.with_(f_nat_hz=frequency_hz), 1.0)
    record = RingDownRecord(with_noise(clean, np.random.default_rng(1)), RATE_HZ, "dmdt")
    result = fit_ring_down(record, "thread", window)
    assert result.reason.startswith("two_resonators"), result.reason
    slowing = 1 - THREAD.phi_max_rad**2 / 16
    assert sorted(frequencies(result.reason)) == pytest.approx(
        [slowing * THREAD.f_nat_hz, slowing * frequency_hz], abs=3.0
    )


def test_one_wide_swing_has_no_far_line():
    for degrees in (40.0, 80.0, 110.0):
        clean = dmdt(THREAD.with_(phi_max_rad=math.radians(degrees)), 0.5)
        record = RingDownRecord(with_noise(clean, np.random.default_rng(2)), RATE_HZ, "dmdt")
        assert find_far_lines(record, THREAD.f_nat_hz) is None
