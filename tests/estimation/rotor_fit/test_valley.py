"""Steps of a rotor's fit, against bounded least squares by scipy, and the way back to the floor after them."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from platform_daemon.estimation.rotor_fit.valley import Layout, Valley, limited_step
from tests.kit.rotor_shots import RATE_HZ, shot_of


@pytest.mark.parametrize("seed", range(8))
def test_what_goes_along_with_a_limited_component_is_solved_for(seed):
    drawn = np.random.default_rng(seed)
    columns = drawn.normal(size=(40, 6)) @ np.diag(10.0 ** drawn.uniform(-2.0, 1.0, 6))
    columns[:, 1] += 3.0 * columns[:, 0]  # two that the data tell only together
    left = drawn.normal(size=40) * 10.0
    most = np.array([0.5, np.inf, np.inf, 0.5, np.inf, np.inf])
    step = limited_step(columns.T @ columns, columns.T @ left, most)
    by_scipy = lsq_linear(columns, left, bounds=(-most, most), method="bvls").x
    assert step == pytest.approx(by_scipy, rel=1e-6, abs=1e-9)


def test_a_component_that_is_cut_off_alone_leaves_the_floor():
    matrix = np.array([[1.0, 0.999], [0.999, 1.0]]) * 1e4
    gradient = matrix @ np.array([3.0, -3.0])
    held = limited_step(matrix, gradient, np.array([0.5, np.inf]))
    cut = np.array([0.5, -3.0])

    def fall(step):
        return 2.0 * gradient @ step - step @ matrix @ step

    assert fall(held) > 0.0 > fall(cut)


def test_what_the_data_do_not_tell_moves_little_on_the_way_back_to_the_floor():
    """A spin below which a contact creeps, so slow that no motion shows it: only what is known beforehand pulls at it,
    and where it gets faster the motion does show it."""
    shot = shot_of("jewel", 1200, (4e-4, 0.0, 0.0), creep_spin_rad_per_s=0.02)
    truth = shot.values
    noise = np.random.default_rng(1).normal(size=(3, 1200)) * shot.sd[:, None]
    shot = replace(shot, samples=shot.rotor(truth).dm_dt(1200, RATE_HZ)[0] + noise)
    layout = Layout.of([shot], ("stator_tilt_rad",), ())
    valley = Valley([shot], layout, [replace(truth, creep_spin_rad_per_s=5.0)], 0.1)
    with ThreadPoolExecutor(2) as pool:
        off = [replace(truth, f_nat_hz=truth.f_nat_hz + 2e-3)]
        normal = valley.linearised(off, pool)
        step, _ = normal.step(1e-9, layout.most_step)
        found = valley.trial(off, step, normal, pool)
    moved = np.log(found.values[0].creep_spin_rad_per_s / truth.creep_spin_rad_per_s)
    assert step[layout.place("creep_spin_rad_per_s")] == 0.5  # as far as one step may
    assert 0.5 <= moved < 0.8  # without a bound on returns: 3
    assert found.total < normal.total - 500.0
