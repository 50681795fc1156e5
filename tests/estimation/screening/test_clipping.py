"""Flat tops and extremes of a record."""

import math

import numpy as np
import pytest

from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.screening.clipping import extremes, find_clipping, flat_runs, saturation
from tests.kit.ring_down_generator import RATE_HZ, Truth, dmdt

T = np.arange(60_000) / 61_035.0
DECAY = np.exp(-0.25 * T) * np.sin(2 * np.pi * 212.0 * T)


def record(levels: float, noise_levels: float) -> np.ndarray:
    noise = np.random.default_rng(1).normal(0, max(noise_levels, 1e-12), T.size)
    return np.rint(levels * DECAY + noise)[None]


@pytest.mark.parametrize("levels", [3.4, 20.0, 109.0, 20_000.0])
@pytest.mark.parametrize("noise_levels", [0.0, 0.3, 3.0, 30.0])
def test_quantised_records_that_stay_in_range_are_not_called_clipped(levels, noise_levels):
    assert saturation(record(levels, noise_levels)) is None


@pytest.mark.parametrize("share", [0.5, 0.9, 0.97])
def test_records_cut_at_a_limit_are(share):
    limit = round(20_000 * share)
    assert "channel 1" in saturation(np.vstack([record(100, 1), np.clip(record(20_000.0, 30.0), -limit, limit)]))


def test_floating_point_and_constant_records_are_not():
    assert saturation(DECAY[None]) is None
    assert saturation(np.zeros((3, 100))) is None


@pytest.mark.parametrize("levels", [pytest.param(20.0, marks=pytest.mark.campaign), 109.0])
def test_a_coarsely_quantised_record_is_fitted(levels):
    u = 0.18 * np.exp(-0.5 * T) * np.sin(2 * np.pi * 424.0 * T)
    noise = np.random.default_rng(0).normal(0, 0.3, (3, T.size))
    samples = np.rint(levels * np.stack([DECAY, u, 0 * u]) + noise) * 6.0 / levels
    found = fit_ring_down(RingDownRecord(samples, 61_035.0, "dmdt"), "thread", 0.5)
    assert "saturated" not in (found.reason or "")


@pytest.mark.parametrize("clipped", [0, 1, 5, 20])
def test_a_few_samples_at_full_scale_are_a_warning_many_a_refusal(clipped):
    signal = dmdt(Truth(), 0.24) + np.random.default_rng(0).normal(0, 0.02, (3, round(0.24 * RATE_HZ)))
    signal = signal[:, : round(0.24 * RATE_HZ)]
    limit = np.sort(np.abs(signal).ravel())[-clipped] if clipped else 2 * np.abs(signal).max()
    found = fit_ring_down(RingDownRecord(np.clip(signal, -limit, limit), RATE_HZ, "dmdt", full_scale=limit), "thread")
    clipping_warnings = [w for w in found.warnings if w.startswith(f"saturated: {clipped} samples")]
    assert (found.verdict, len(clipping_warnings)) == (("good", 1 if clipped else 0) if clipped < 8 else ("refused", 0))
    assert clipped < 8 or found.reason.startswith("saturated")


def test_a_small_pile_is_clipping_but_not_severe():
    y = np.sin(np.linspace(0.0, 60.0, 20_000))[None] * np.exp(-np.linspace(0.0, 3.0, 20_000))
    limit = np.sort(y.ravel())[-10]
    found = find_clipping(np.minimum(y, limit))
    assert (found.samples, found.side, found.severe) == (10, "top", False)
    assert saturation(np.minimum(y, limit)) is None


@pytest.mark.parametrize("n", [64, 511, 512, 513, 5000])
def test_extremes_are_those_of_numpy(n):
    y = np.random.default_rng(n).standard_normal(n)
    assert extremes(y)[:2] == (y.min(), y.max())


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("place", [0, 700, 999])
def test_a_sample_that_is_not_finite_makes_the_lowest_one_nan(bad, place):
    y = np.zeros(1000)
    y[place] = bad
    assert math.isnan(extremes(y)[0])


def test_flat_tops_are_reached_by_at_least_as_many_fourth_samples_as_there_are_runs():
    y = np.clip(np.sin(0.05 * np.arange(4000)), -2.0, 0.99)
    low, high, reached = extremes(y)
    tops, bottoms = flat_runs(y, low, high)
    assert (tops, bottoms) == (32, 0)
    assert reached >= tops


def test_extremes_do_not_depend_on_how_the_record_lies_in_memory():
    whole = np.random.default_rng(0).standard_normal((3, 2000))
    for row in whole[:, 100:1500]:
        assert extremes(row) == extremes(row.copy())
