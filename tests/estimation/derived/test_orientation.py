"""Angles between orientations do not depend on how the vectors are written."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from platform_daemon.estimation import Estimate, FitResult
from platform_daemon.estimation.derived import (
    best_orientation,
    error_angle,
    mean_orientation,
    orientation_spread,
    orientations,
)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-4, 0.3, 3.0, math.pi])
def test_the_error_angle_is_the_rotation_between_two_orientations(angle):
    rng = np.random.default_rng(2)
    reference = Rotation.random(random_state=rng)
    axis = rng.standard_normal(3)
    turned = reference * Rotation.from_rotvec(angle * axis / np.linalg.norm(axis))
    found = error_angle(turned.as_rotvec(), reference.as_rotvec())
    assert found.shape == ()
    assert found == pytest.approx(angle, abs=1e-15, rel=1e-7)
    assert found == pytest.approx(
        float(np.arccos(np.clip((np.trace((reference.inv() * turned).as_matrix()) - 1) / 2, -1, 1))), abs=1e-7
    )


def test_vectors_on_both_sides_of_length_pi_are_close():
    one, other = np.array([0.0, 0.0, math.pi - 1e-3]), np.array([0.0, 0.0, -math.pi + 1e-3])
    assert error_angle(one, other) == pytest.approx(2e-3)
    mean = mean_orientation(np.array([one, other]))
    assert error_angle(mean, np.array([0.0, 0.0, math.pi])) < 1e-9


def test_the_chordal_mean_minimises_the_sum_of_squared_chords():
    rng = np.random.default_rng(3)
    centre = Rotation.random(random_state=rng)
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
    assert spread.angle_rad.shape == (4000,)
    assert spread.mean_rad == pytest.approx(sigma * math.sqrt(8 / math.pi), rel=0.02)
    assert spread.sd_rad == pytest.approx(sigma * math.sqrt(3 - 8 / math.pi), rel=0.05)
    own = orientation_spread(frames)
    assert error_angle(own.reference, centre.as_rotvec()) < 4 * sigma / math.sqrt(4000) * math.sqrt(3)


def frame(vector, r2, verdict="good"):
    named = dict(zip(("rodrigues_x", "rodrigues_y", "rodrigues_z"), vector, strict=True))
    return FitResult(verdict, parameters={n: Estimate(v, 1e-4) for n, v in named.items()}, r2=r2)


def test_the_best_reference_is_the_fit_with_the_highest_r2_and_refused_frames_do_not_count():
    series = [frame((0.1, 0.0, 0.0), 0.99), frame((0.2, 0.0, 0.0), 0.9999), FitResult("refused", reason="no_signal: x")]
    vectors, r2 = orientations(series)
    assert vectors.shape == (2, 3)
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
    assert math.isnan(orientation_spread(np.zeros((1, 3))).sd_rad)
