"""Angles between orientations do not depend on how the vectors are written."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from platform_daemon.estimation.parameters import RODRIGUES
from platform_daemon.estimation.physics.mirror import on_one_branch
from platform_daemon.features.fit.series.orientation import (
    best_orientation,
    error_angle,
    mean_orientation,
    orientation_spread,
)

HALF_TURN_ABOUT_U = Rotation.from_matrix(np.diag([1.0, -1.0, -1.0]))


def by_convention(turned):
    """What a fit publishes: the twin with e_v . x >= 0."""
    return turned * HALF_TURN_ABOUT_U if turned.as_matrix()[0, 1] < 0 else turned


def flipping_series(rng, count, sigma):
    """Fits of a resonator that stands still with e_v (as good as) perpendicular to x, in noise; and what it is."""
    angles = rng.uniform(0, 2 * math.pi, 2)
    e_v = np.array([0.0, math.cos(angles[0]), math.sin(angles[0])])
    e_u = math.cos(angles[1]) * np.array([1.0, 0.0, 0.0]) + math.sin(angles[1]) * np.cross(e_v, [1.0, 0.0, 0.0])
    centre = Rotation.from_matrix(np.array([e_u, e_v, np.cross(e_u, e_v)]).T)
    turned = [centre * Rotation.from_rotvec(sigma * rng.standard_normal(3)) for _ in range(count)]
    return np.array([by_convention(t).as_rotvec() for t in turned]), centre


@pytest.mark.parametrize("seed", range(40))
def test_a_resonator_that_stands_still_does_not_flip_between_its_twins(seed):
    rng = np.random.default_rng(seed)
    vectors, centre = flipping_series(rng, int(rng.integers(2, 40)), 1e-3)
    spread = orientation_spread(vectors)
    assert max(spread.angle_rad) < 6e-3
    assert error_angle(spread.reference_rodrigues_rad, centre.as_rotvec()) < 4e-3
    assert Rotation.from_rotvec(spread.reference_rodrigues_rad).as_matrix()[0, 1] >= -1e-15
    against_truth = orientation_spread(vectors, centre.as_rotvec())
    assert max(against_truth.angle_rad) < 6e-3


@pytest.mark.parametrize("seed", range(20))
def test_far_from_the_border_the_mean_is_that_of_the_rotations_as_they_are(seed):
    rng = np.random.default_rng(seed)
    centre = Rotation.random(random_state=rng)
    while abs(centre.as_matrix()[0, 1]) < 0.2:
        centre = Rotation.random(random_state=rng)
    centre = by_convention(centre)
    turned = centre * Rotation.from_rotvec(0.02 * rng.standard_normal((30, 3)))
    mean = Rotation.from_rotvec(mean_orientation(turned.as_rotvec()))
    assert (mean.inv() * turned.mean()).magnitude() < 1e-9


def test_psi_and_a_bias_torque_follow_the_twin_that_a_series_is_told_by():
    rng = np.random.default_rng(8)
    vectors, _ = flipping_series(rng, 30, 1e-3)
    first = Rotation.from_rotvec(vectors[0])
    other = [(first.inv() * Rotation.from_rotvec(v)).magnitude() > 1 for v in vectors]
    assert 0 < sum(other) < 30
    frames = [
        dict(zip(RODRIGUES, v, strict=True))
        | {"psi_start_rad": 1.0 + (math.pi if o else 0), "bias_rad_per_s2": -5.0 if o else 5.0, "f_nat_hz": 200.0}
        for v, o in zip(vectors, other, strict=True)
    ]
    told, mean = on_one_branch(frames)
    assert np.ptp([f["psi_start_rad"] for f in told]) < 1e-12
    assert len({f["bias_rad_per_s2"] for f in told}) == 1
    assert {f["f_nat_hz"] for f in told} == {200.0}
    assert max(np.linalg.norm([f[n] - m for n, m in zip(RODRIGUES, mean, strict=True)]) for f in told) < 0.02
    volts = [{"psi_start_rad": 1.0}, {"psi_start_rad": 1.0 + math.pi}]
    assert on_one_branch(volts) == (volts, None)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-4, 0.3, 3.0, math.pi])
def test_the_error_angle_is_the_rotation_between_two_orientations(angle):
    rng = np.random.default_rng(2)
    reference = Rotation.random(random_state=rng)
    axis = rng.standard_normal(3)
    turned = reference * Rotation.from_rotvec(angle * axis / np.linalg.norm(axis))
    found = error_angle(turned.as_rotvec(), reference.as_rotvec())
    assert found.shape == ()
    about_u = abs(axis[0]) / np.linalg.norm(axis) * math.sin(angle / 2)
    expected = min(angle, 2 * math.acos(min(about_u, 1.0)))  # of the twin, which a large turn about e_u comes near to
    assert found == pytest.approx(expected, abs=1e-15, rel=1e-7)


def test_vectors_on_both_sides_of_length_pi_are_close():
    one, other = np.array([0.0, 0.0, math.pi - 1e-3]), np.array([0.0, 0.0, -math.pi + 1e-3])
    assert error_angle(one, other) == pytest.approx(2e-3)
    mean = mean_orientation(np.array([one, other]))
    assert error_angle(mean, np.array([0.0, 0.0, math.pi])) < 1e-9


def test_the_chordal_mean_minimises_the_sum_of_squared_chords():
    rng = np.random.default_rng(3)
    centre = by_convention(Rotation.random(random_state=rng))
    frames = (centre * Rotation.from_rotvec(0.2 * rng.standard_normal((50, 3)))).as_rotvec()
    mean = mean_orientation(frames)

    def chords(vector):
        return np.sum((Rotation.from_rotvec(frames).as_matrix() - Rotation.from_rotvec(vector).as_matrix()) ** 2)

    assert all(chords(mean) < chords(mean + 1e-3 * rng.standard_normal(3)) for _ in range(20))


def test_small_isotropic_errors_have_the_maxwell_mean_and_sd():
    rng = np.random.default_rng(4)
    centre, sigma = Rotation.random(random_state=rng), 1e-3
    frames = (centre * Rotation.from_rotvec(sigma * rng.standard_normal((4000, 3)))).as_rotvec()
    spread = orientation_spread(frames, centre.as_rotvec())
    assert len(spread.angle_rad) == 4000
    assert spread.mean_rad == pytest.approx(sigma * math.sqrt(8 / math.pi), rel=0.02)
    assert spread.std_rad == pytest.approx(sigma * math.sqrt(3 - 8 / math.pi), rel=0.05)
    own = orientation_spread(frames)
    assert error_angle(own.reference_rodrigues_rad, centre.as_rotvec()) < 4 * sigma / math.sqrt(4000) * math.sqrt(3)


def test_the_best_reference_is_the_fit_with_the_highest_r2():
    vectors, r2 = np.array([[0.1, 0.0, 0.0], [0.2, 0.0, 0.0]]), np.array([0.99, 0.9999])
    best = best_orientation(vectors, r2)
    assert np.array_equal(best, [0.2, 0.0, 0.0])
    spread = orientation_spread(vectors, best)
    assert spread.angle_rad == pytest.approx([0.1, 0.0])
    assert np.array_equal(best_orientation(vectors, np.array([0.9, np.nan])), vectors[0])


def test_nothing_to_compare_is_an_error():
    for bad in (np.empty((0, 3)), np.zeros(3), np.array([[np.nan, 0, 0]])):
        with pytest.raises(ValueError, match="orientations"):
            orientation_spread(bad)
    with pytest.raises(ValueError, match="R2"):
        best_orientation(np.zeros((2, 3)), np.array([np.nan, np.nan]))
    assert orientation_spread(np.zeros((1, 3))).std_rad is None
