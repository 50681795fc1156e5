"""Steps of a rotor's fit, against bounded least squares by scipy, and the way back to the floor after them."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from platform_daemon.estimation.rotor_fit.fit import fit_rotor, windows_s
from platform_daemon.estimation.rotor_fit.layout import Layout
from platform_daemon.estimation.rotor_fit.valley import Valley, limited_step
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
        here = valley.start(off, normal, pool)
        found, which = valley.trials(here, [step], [1.0], normal, pool)
        with_less_room, _ = valley.trials(here, [step], [0.1], normal, pool)
        beside, first = valley.trials(here, [-30.0 * step, step, 0.1 * step], [1.0] * 3, normal, pool)
    assert (which, first) == (0, 1)  # the first one that leads down, though the last one may lead lower
    assert beside.total == pytest.approx(found.total, abs=0.1)
    moved = np.log(found.values[0].creep_spin_rad_per_s / truth.creep_spin_rad_per_s)
    assert step[layout.place("creep_spin_rad_per_s")] == 0.5  # as far as one step may
    assert 0.5 <= moved < 0.8  # without a bound on returns: 3
    assert found.total < normal.total - 200.0
    assert 0.5 <= np.log(with_less_room.values[0].creep_spin_rad_per_s / truth.creep_spin_rad_per_s) < 0.55


def test_only_a_component_that_the_data_know_better_than_its_bound_is_held_short():
    known, most = np.array([1e4, 1e-2]), np.array([0.5, 0.5])
    normal = _normal(known)
    assert normal.held_short(np.array([-0.5, 0.1]), most)  # known to 0.01
    assert not normal.held_short(np.array([0.1, 0.5]), most)  # known to 10
    assert not normal.held_short(np.array([0.4, 0.4]), most)
    assert normal.whole_fall() == pytest.approx(1e-4 + 100.0)


def _normal(known):
    """Normal equations of two parameters that are known independently, with a gradient of 1 in both."""
    valley = Valley([], Layout((), (), 2), [], 0.0)
    empty = valley.linearised([], ThreadPoolExecutor(1))
    return replace(empty, matrix=np.diag(known), gradient=np.ones(2))


@pytest.mark.parametrize(("off_hz", "jacobians"), [(1e-4, 1), (1e-3, 2)])
def test_a_small_step_that_keeps_what_the_whole_one_promises_ends_a_fit(off_hz, jacobians, monkeypatch):
    """After a large one the next place is looked at too."""
    shot = shot_of("thread", 1200, (2e-4, 0.0, 0.0))
    truth, seen = shot.values, []
    noise = np.random.default_rng(2).normal(size=(3, 1200)) * shot.sd[:, None]
    shot = replace(shot, samples=shot.rotor(truth).dm_dt(1200, RATE_HZ)[0] + noise)
    whole = Valley.linearised
    monkeypatch.setattr(Valley, "linearised", lambda self, *args: seen.append(1) or whole(self, *args))
    begun = replace(shot, values=replace(truth, f_nat_hz=truth.f_nat_hz + off_hz))
    held = ("distance_m", "side_damping_per_s", "lean_damping_per_s", "damping_axis_to_thread")
    with ThreadPoolExecutor(2) as pool:
        found = fit_rotor([begun], "stator_tilt_rad", pool, first_window_s=1.0, held=held, whole=False)
        assert len(seen) == jacobians
        begun = replace(shot, values=found.values[0])
        again = fit_rotor([begun], "stator_tilt_rad", pool, first_window_s=1.0, held=held)
    assert again.total_chi2 > found.total_chi2 - 1.0


def test_windows_end_with_the_whole_and_before_it_the_share_that_predicts_it():
    assert windows_s(0.4, 2.0) == pytest.approx([0.4, 0.8, 1.4, 2.0])
    assert windows_s(0.4, 2.0, predicts=False) == pytest.approx([0.4, 0.8, 2.0])
    assert windows_s(0.4, 0.5, predicts=False) == [0.5]
    assert windows_s(np.inf, 0.5) == windows_s(np.inf, 0.5, predicts=False) == [0.5]
