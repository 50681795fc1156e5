"""Extremes, flat tops and block means against numpy; the fitted signal against the basis it comes from."""

import math

import numpy as np
import pytest

from platform_daemon.estimation.initial_guess.harmonic_fit import fit_harmonics
from platform_daemon.estimation.moments.workspace import Workspace
from platform_daemon.estimation.physics.models import JEWEL, THREAD
from platform_daemon.estimation.physics.trajectory.basis_functions import DIPOLE, STATE
from platform_daemon.estimation.physics.trajectory.direct import MotionParameters, Trajectory
from platform_daemon.estimation.screening.clipping import extremes, flat_runs
from platform_daemon.estimation.screening.frequency_search import block_means


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


@pytest.mark.parametrize(("first", "block", "blocks"), [(0, 1, 50), (7, 8, 100), (3, 23, 40)])
def test_block_means_are_those_of_numpy(first, block, blocks):
    y = np.random.default_rng(1).standard_normal((2, 1000))
    expected = y[:, first : first + block * blocks].reshape(2, blocks, block).mean(axis=2)
    assert np.allclose(block_means(y, first, block, blocks), expected, rtol=1e-13, atol=1e-15)


@pytest.mark.parametrize(("model", "values"), [(THREAD, (0.25,)), (JEWEL, (0.25, 900.0))])
@pytest.mark.parametrize("observable", [DIPOLE, STATE])
@pytest.mark.parametrize("block", [1, 23, 150])
def test_block_means_of_the_motion_are_those_of_its_basis(model, values, observable, block):
    d, dt_s, blocks = MotionParameters(2.0 * math.pi * 213.0, 1.3, 0.8, values), 1.6e-5, 40
    expected = Trajectory(model, d, (5 + block * blocks) * dt_s).basis(5, 5 + block * blocks, dt_s, observable)[:2]
    expected = expected.reshape(2, blocks, block).mean(axis=2)
    found = Workspace(model).block_means(d, 5, blocks, block, dt_s, observable, 0.0)
    assert np.allclose(found, expected, atol=3e-9)


@pytest.mark.parametrize("true_hz", [196.0, 209.0, 210.0, 211.5, 228.0])
def test_a_snapshot_finds_a_frequency_near_and_far(true_hz):
    dt_s, n = 1.6e-5, 2980
    phase = 2.0 * math.pi * true_hz * dt_s * np.arange(n)
    y = np.stack([2.0 * np.cos(phase), 0.3 * np.sin(2.0 * phase)])
    seen = fit_harmonics(y, 0, n, dt_s, 210.0, np.full(2, 1e-3))
    assert seen.omega / (2.0 * math.pi) == pytest.approx(true_hz, rel=1e-4)
    assert np.abs(seen.z[0]) == pytest.approx([2.0, 0.0], abs=2e-3)
    assert np.abs(seen.z[1]) == pytest.approx([0.0, 0.3], abs=2e-3)
