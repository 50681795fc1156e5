"""Orientations: Rodrigues vectors against scipy's rotations and against differences."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from platform_daemon.estimation.physics.rotation import (
    rodrigues_from_rotation,
    rodrigues_jacobian,
    rotation_from_rodrigues,
)

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
