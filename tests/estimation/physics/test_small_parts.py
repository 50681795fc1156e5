"""Rotations, labels, harmonics, windows: each against its definition."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from scipy.special import ellipj, ellipk

from platform_daemon.estimation.physics.orbit import (
    amplitude_from_second_harmonic,
    amplitude_from_third_harmonic,
    first_harmonic,
    frequency_ratio,
)
from platform_daemon.estimation.physics.rotation import (
    rodrigues_from_rotation,
    rodrigues_jacobian,
    rotation_from_rodrigues,
)
from platform_daemon.estimation.physics.trajectory.initial_conditions import (
    NoInitialConditionsError,
    initial_conditions_of_state,
    state_of_initial_conditions,
)
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.screening.windows import select_window

VECTORS = st.tuples(*[st.floats(-1.8, 1.8) for _ in range(3)]).map(np.array)


@given(VECTORS)
@settings(max_examples=60, deadline=None)
def test_rodrigues_vectors_and_matrices_translate_both_ways(vector):
    matrix = rotation_from_rodrigues(vector)
    assert np.allclose(matrix, Rotation.from_rotvec(vector).as_matrix(), atol=1e-13)
    assert np.allclose(rodrigues_from_rotation(matrix), vector, atol=1e-9)


@pytest.mark.parametrize("axis", [[1, 0, 0], [0, 1, 0], [0, 0, -1], [0.6, 0.0, 0.8]])
def test_a_half_turn_has_a_rodrigues_vector_of_length_pi(axis):
    matrix = rotation_from_rodrigues(math.pi * np.array(axis, dtype=float))
    assert np.linalg.norm(rodrigues_from_rotation(matrix)) == pytest.approx(math.pi)


@pytest.mark.parametrize("vector", [[1e-6, 0, 0], [0.3, -0.2, -1.5], [0.0, 3.1, 0.1], [2.0, -2.0, 1.0]])
def test_local_rotation_errors_become_rodrigues_errors(vector):
    vector = np.array(vector)
    matrix = rotation_from_rodrigues(vector)
    step = 1e-6
    columns = [(rodrigues_from_rotation(matrix @ rotation_from_rodrigues(step * e)) - vector) / step for e in np.eye(3)]
    assert np.allclose(rodrigues_jacobian(vector), np.array(columns).T, atol=1e-4)


@given(st.floats(0.01, 2.5), st.floats(0.0, 2 * math.pi, exclude_max=True))
@settings(max_examples=80, deadline=None)
def test_a_label_and_its_state_translate_both_ways(phi_max, psi):
    phi, v = state_of_initial_conditions(phi_max, psi)
    back_max, back_psi, _ = initial_conditions_of_state(phi, v)
    assert back_max == pytest.approx(phi_max, rel=1e-12)
    assert math.cos(back_psi - psi) == pytest.approx(1.0, abs=1e-12)
    assert 0.0 <= back_psi < 2 * math.pi


@pytest.mark.parametrize(("phi_max", "psi"), [(0.39, 5.84), (0.917, 3.863), (1.3, 0.0), (0.2, 1.6)])
def test_the_derivatives_of_the_label_agree_with_differences(phi_max, psi):
    state = np.array(state_of_initial_conditions(phi_max, psi))
    _, _, jacobian = initial_conditions_of_state(*state)
    for k in range(2):
        h = 1e-6 * np.eye(2)[k]
        up, down = initial_conditions_of_state(*(state + h)), initial_conditions_of_state(*(state - h))
        turn = (up[1] - down[1] + math.pi) % (2 * math.pi) - math.pi
        assert np.allclose(jacobian[:, k], [(up[0] - down[0]) / 2e-6, turn / 2e-6], atol=1e-6)


@pytest.mark.parametrize("state", [(0.0, 0.0), (0.1, 2.5)])
def test_a_state_without_a_label_is_an_error(state):
    with pytest.raises(NoInitialConditionsError):
        initial_conditions_of_state(*state)


def orbit_harmonics(amplitude):
    """Frequency ratio and amplitudes of harmonics 1..3 of d(sin phi)/dt, d(cos phi)/dt, by Jacobi functions."""
    k = math.sin(amplitude / 2)
    period = 4 * ellipk(k * k)
    s = np.linspace(0, period, 4096, endpoint=False)
    sn, _, dn, _ = ellipj(s + period / 4, k * k)
    phi = 2 * np.arcsin(k * sn)
    v = np.gradient(phi, s, edge_order=2)
    del dn
    waves = [np.abs(np.fft.rfft(x)) * 2 / s.size for x in (v * np.cos(phi), -v * np.sin(phi))]
    return 2 * math.pi / period, waves[0][1], waves[1][2], waves[0][3]


@pytest.mark.parametrize("degrees", [5.0, 20.0, 53.0, 75.0])
def test_closed_form_harmonics_agree_with_the_jacobi_orbit(degrees):
    amplitude = math.radians(degrees)
    frequency, v1, u2, v3 = orbit_harmonics(amplitude)
    assert frequency_ratio(amplitude) == pytest.approx(frequency, rel=1e-10)
    assert first_harmonic(amplitude) == pytest.approx(v1, rel=1e-4)
    assert amplitude_from_second_harmonic(u2 / v1) == pytest.approx(amplitude, rel=1e-4)
    assert amplitude_from_third_harmonic(v3 / v1) == pytest.approx(amplitude, rel=1e-3)


def test_the_d30_window_ends_where_the_strongest_channel_has_30_percent_left():
    rate = 20000.0
    t = np.arange(60000) / rate
    signal = np.exp(-t) * np.sin(2 * np.pi * 200 * t) * np.array([[1.0], [5.0], [0.1]])
    chosen = select_window(RingDownRecord(signal, rate, "dmdt"), "d30", 200.0, np.full(3, 1e-9))
    assert chosen.last / rate == pytest.approx(-math.log(0.3), abs=0.01)
    assert chosen.notes == ()


def test_a_window_in_seconds_counts_from_time_zero():
    record = RingDownRecord(np.zeros((3, 1000)), 1000.0, "dmdt", valid_from=100)
    chosen = select_window(record, 0.5, 100.0, np.ones(3))
    assert (chosen.first, chosen.last) == (100, 500)


def test_n50_is_the_first_240_milliseconds():
    record = RingDownRecord(np.zeros((3, 1000)), 1000.0, "dmdt")
    assert select_window(record, "n50", 100.0, np.ones(3)).last == 240
