"""Tops that are cut off: flat in the samples, or flat under noise that was added after them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.physics.models import JEWEL, THREAD
from platform_daemon.estimation.physics.torques.quadratic_drag import QUADRATIC_DRAG
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.screening.clipping import peaks_at
from tests.kit.pendulum import RATE, swing
from tests.kit.ring_down_generator import RATE_HZ, Truth, dmdt

TRUTHS = {"thread": Truth(phi_max_rad=0.5), "jewel": Truth(phi_max_rad=0.9, tf_over_i_rad_per_s2=1100.0)}


def clipped(variant, cut, sides, channel=0):
    """dm/dt of 0.24 s whose channel lacks so much of its peak on these sides, with noise on top."""
    signal = dmdt(TRUTHS[variant], 0.24)
    level = (1 - cut) * np.abs(signal[channel]).max()
    low, high = (-level if -1 in sides else -np.inf), (level if 1 in sides else np.inf)
    signal[channel] = np.clip(signal[channel], low, high)
    return RingDownRecord(signal + np.random.default_rng(0).normal(0, 0.02, signal.shape), RATE_HZ, "dmdt")


@pytest.mark.parametrize("variant", ["thread", "jewel"])
@pytest.mark.parametrize("sides", [(1,), (-1,), (1, -1)])
@pytest.mark.parametrize("cut", [0.12, 0.2])
def test_a_channel_clipped_before_its_noise_is_refused_with_channel_and_side(variant, sides, cut):
    result = fit_ring_down(clipped(variant, cut, sides), variant, 0.24)
    assert result.verdict == "refused"
    assert result.reason.startswith("saturated: channel 0")
    if len(sides) == 1:
        assert f"clipped at its {'top' if sides == (1,) else 'bottom'}" in result.reason


@pytest.mark.parametrize("variant", ["thread", "jewel"])
def test_a_little_clipping_under_noise_is_a_warning(variant):
    result = fit_ring_down(clipped(variant, 0.035, (1, -1)), variant, 0.24)
    assert result.verdict == "good", result.reason
    assert any(w.startswith("saturated: channel 0 is clipped") for w in result.warnings)


@pytest.mark.parametrize("strength", [3e-4, 1e-3, 3e-3])
@pytest.mark.parametrize("base", [THREAD, JEWEL])
def test_a_torque_that_the_model_lacks_is_no_clipping(base, strength):
    truth = fit_ring_down(RingDownRecord(dmdt(TRUTHS[base.name], 0.24), RATE_HZ, "dmdt"), base, 0.24)
    model = base.with_terms("with drag", QUADRATIC_DRAG)
    state = truth.fitted.state
    dynamics = replace(state.dynamics, values=(*state.dynamics.values, strength))
    lacking = type(truth.fitted)(model, type(state)(dynamics, state.observation, state.offsets))
    signal = type(truth)("good", fitted=lacking).model_signal(round(0.24 * RATE_HZ), RATE_HZ)
    noisy = signal + np.random.default_rng(0).normal(0, 0.002, signal.shape)
    result = fit_ring_down(RingDownRecord(noisy, RATE_HZ, "dmdt"), base, 0.24)
    assert "saturated" not in (result.reason or "") + " ".join(result.warnings)


@pytest.mark.parametrize("level", [1.0, 1.15])
def test_a_few_long_flat_tops_of_an_angle_are_refused(level):
    noisy = swing(1.2, 40) + np.random.default_rng(0).normal(0, 1e-4, 8000)
    result = fit_ring_down(RingDownRecord(np.clip(noisy, -level, level)[None], RATE, "angle"), "thread", 1e9)
    assert result.verdict == "refused"
    assert result.reason.startswith("saturated")


@pytest.mark.parametrize("steps", [30, 300])
def test_an_encoder_held_at_its_start_and_its_coarse_tops_are_not(steps):
    angle = np.concatenate([np.full(300, 1.2), swing(1.2, 30)])
    step = 1.2 / steps
    read = np.round(angle / step) * step
    result = fit_ring_down(RingDownRecord(read[None], RATE, "angle"), "thread", 1e9)
    assert "saturated" not in (result.reason or "")


def test_peaks_are_counted_once_each_however_they_flicker():
    y = np.cos(2 * math.pi * np.arange(400) / 100)
    y = np.minimum(y, 0.9)
    y[[200, 300]] = 0.89
    assert peaks_at(y, 0.9) == 5
    assert peaks_at(y, -1.0) == 0
