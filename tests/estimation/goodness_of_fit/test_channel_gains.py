"""Gains and crosstalk that the calibration does not know, told apart from a spike."""

import numpy as np
import pytest

from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.ring_down_generator import NOISE_SD, RATE_HZ, Truth, dmdt

TRUTH = Truth(phi_max_rad=0.9, tf_over_i_rad_per_s2=1100.0)
SIGNAL = dmdt(TRUTH, 0.24)


def warnings_of(signal, model="jewel"):
    noise = np.random.default_rng(1).normal(size=signal.shape) * NOISE_SD[:, None]
    result = fit_ring_down(RingDownRecord(signal + noise, RATE_HZ, "dmdt"), model, 0.24)
    assert result.verdict == "good", result.reason
    return result.warnings


def names(warnings):
    return {warning.partition(":")[0] for warning in warnings}


@pytest.mark.parametrize("channel", [0, 1])
def test_another_gain_of_a_channel_is_named_with_its_size(channel):
    gains = np.ones(3)
    gains[channel] = 1.03
    (said,) = [w for w in warnings_of(gains[:, None] * SIGNAL) if w.startswith("channel_gains: ")]
    change = float(said.partition("about ")[2].partition(" %")[0])
    assert 1.0 < change < 2.0  # a common gain of both channels, half of the change, is the moment
    assert "off centre" in said


def test_a_rotation_and_a_common_gain_are_orientation_and_moment():
    turned = np.array([[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
    assert names(warnings_of(1.03 * turned @ SIGNAL)) == set()


def test_a_spike_is_no_gain():
    spiked = SIGNAL.copy()
    at = round(0.1 * RATE_HZ)
    spiked[0, at : at + 60] += 1.0
    said = warnings_of(spiked)
    assert "residual_not_steady" in names(said)
    assert "channel_gains" not in names(said)
    (where,) = [w for w in said if w.startswith("residual_not_steady")]
    assert "around t = 0.09" in where or "around t = 0.1" in where
