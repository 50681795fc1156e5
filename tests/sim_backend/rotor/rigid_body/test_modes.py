import numpy as np
import pytest
from scipy.signal import find_peaks

from sim_backend.rotor.rigid_body.modes import modes
from sim_backend.rotor.rigid_body.motion import move
from sim_backend.rotor.rigid_body.rest import distance_from_rest, moved, rest_state
from tests.kit.rigid_rotors import rigid

STEP_S, SAMPLES = 2e-4, 8192


def small_modes(name, **more):
    rotor, p = rigid(name, **more)
    return modes(rest_state(p, rotor.omega_rad_per_s), p)


def spectrum_hz(rotor, p, small):
    """Peaks of n and the moment's motion after a small push, Hz."""
    y = moved(rest_state(p, rotor.omega_rad_per_s), small)
    track = np.empty((SAMPLES, 6))
    for k in range(SAMPLES):
        y = move(0.0, STEP_S, y, p, rotor.omega_rad_per_s).internal_state
        track[k] = [*y[3:6], *y[10:13]]
    window = np.hanning(SAMPLES)[:, None]
    found = set()
    for power in (np.abs(np.fft.rfft(track * window, 8 * SAMPLES, axis=0)) ** 2).T:
        found |= {k / (8 * SAMPLES * STEP_S) for k in find_peaks(power, height=1e-3 * power.max())[0]}
    return np.array(sorted(found))


def test_side_modes_of_the_thread_lie_where_an_independent_computation_put_them():
    found = small_modes("thread")
    assert [m.frequency_hz for m in found.sides] == pytest.approx([91, 116, 231, 327], abs=1.0)
    assert found.main.frequency_hz == pytest.approx(215.69, rel=1e-6)
    assert found.main.decay_per_s == pytest.approx(0.2465, rel=1e-6)


def test_the_jewels_rotor_rolls_at_137_and_150_hz():
    found = small_modes("jewel")
    assert [m.frequency_hz for m in found.sides] == pytest.approx([137, 150], rel=0.015)
    assert found.main.frequency_hz == pytest.approx(213.25, rel=1e-6)


def test_side_damping_is_the_decay_of_every_side_mode():
    assert [m.decay_per_s for m in small_modes("thread", side=20.0).sides] == pytest.approx([20.0] * 4, rel=1e-6)


@pytest.mark.parametrize("name", ["thread", "jewel"])
def test_a_defect_moves_the_main_mode_and_a_side_mode_takes_part_in_it(name):
    straight, tilted = small_modes(name), small_modes(name, side=20.0, defects={"stator_tilt_rad": 0.02})
    assert 1e-4 < abs(tilted.main.frequency_hz / straight.main.frequency_hz - 1) < 1e-2
    assert tilted.main.decay_per_s > straight.main.decay_per_s
    assert np.abs(tilted.main.shape[:4]).max() > 1e-2


@pytest.mark.parametrize("name", ["thread", "jewel"])
def test_small_motions_have_the_frequencies_of_the_linear_analysis(name):
    rotor, p = rigid(name, defects={"stator_tilt_rad": 0.02})
    p[20:22] = 0.0
    rest = rest_state(p, rotor.omega_rad_per_s)
    found = modes(rest, p)
    push = np.array([1e-4, 8e-5, 1e-4, -1e-4, 0.0 if p[0] else 1e-4])
    if p[0]:
        push[2:4] = -p[3] / p[4] * push[:2]  # it rolls; a turn about n would only be stopped by friction
    peaks = spectrum_hz(rotor, p, push)
    wanted = [m.frequency_hz for m in found.sides] + ([] if p[0] else [found.main.frequency_hz])
    for frequency_hz in wanted:
        assert np.min(np.abs(peaks / frequency_hz - 1)) < 5e-3, (frequency_hz, peaks)


def test_a_jewel_tilted_about_the_stator_is_a_stator_tilted_the_other_way():
    one = small_modes("jewel", defects={"stator_tilt_rad": 0.05})
    other = small_modes("jewel", defects={"jewel_tilt_rad": -0.05, "jewel_tilt_pivot": "stator"})
    ours, theirs = ([m.frequency_hz for m in (x.main, *x.sides)] for x in (one, other))
    assert ours == pytest.approx(theirs, rel=1e-7)


@pytest.mark.parametrize("pivot", ["contact", "rotor", "stator"])
def test_every_pivot_leaves_a_place_of_rest_in_which_nothing_moves(pivot):
    rotor, p = rigid("jewel", gravity=[9.8, 0.0, 0.0], defects={"jewel_tilt_rad": 0.1, "jewel_tilt_pivot": pivot})
    y = rest_state(p, rotor.omega_rad_per_s)
    assert (
        distance_from_rest(move(0.0, 0.1, y, p, rotor.omega_rad_per_s).internal_state, y, p, rotor.omega_rad_per_s)
        < 1e-9
    )


def test_a_stator_moved_across_its_moment_changes_nothing_to_first_order_and_along_it_does():
    straight = small_modes("thread").main.frequency_hz
    along = small_modes("thread", defects={"stator_offset_m": [3e-4, 0.0]})
    assert abs(along.main.frequency_hz - straight) > 1e-3
    assert np.abs(along.main.shape[:4]).max() > 1e-3
