"""Means and scatter over the frames of a series; orientations are averaged as rotations."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from platform_daemon.estimation.parameters import RODRIGUES
from platform_daemon.features.fit.derived import series_quantities
from platform_daemon.features.fit.series.summary import summary
from tests.kit.frame_fits import good_frame


def frame(k, rotation, r2=0.99, **more):
    vector = dict(zip(RODRIGUES, map(float, rotation.as_rotvec()), strict=True))
    return good_frame(k, r2, f_nat_hz=200.0, **vector, **more)


def test_orientations_near_half_a_turn_are_averaged_as_rotations():
    axis = np.array([0.6, 0.0, 0.8])
    truth = Rotation.from_rotvec(math.pi * axis)
    rng = np.random.default_rng(1)
    turned = [truth * Rotation.from_rotvec(0.02 * rng.standard_normal(3)) for _ in range(40)]
    frames = [frame(k, r) for k, r in enumerate(turned)]
    lengths = [r.as_rotvec() @ axis for r in turned]
    assert min(lengths) < 0 < max(lengths)  # both names occur
    found = summary(frames)
    mean = Rotation.from_rotvec([found[f"rodrigues_{a}"].mean for a in "xyz"])
    assert (mean.inv() * Rotation.concatenate(turned).mean()).magnitude() < 1e-9
    assert all(found[f"rodrigues_{a}"].std < 0.1 for a in "xyz")


def test_the_mean_of_psi_belongs_to_the_mean_orientation_of_a_resonator_on_the_border_of_the_convention():
    rng = np.random.default_rng(2)
    frames = []
    for k in range(12):  # e_v along y: noise decides on which side of x = 0 it is found, and psi with it
        turned = Rotation.from_rotvec(1e-3 * rng.standard_normal(3))
        other = turned.as_matrix()[0, 1] < 0
        turned = turned * Rotation.from_rotvec([math.pi, 0, 0]) if other else turned
        psi = 1.0 + (math.pi if other else 0.0) + 1e-3 * rng.standard_normal()
        frames.append(frame(k, turned, psi_start_rad=psi))
    flipped = {f.values["psi_start_rad"] > 2 for f in frames}
    assert flipped == {True, False}
    found = summary(frames)
    mean = Rotation.from_rotvec([found[f"rodrigues_{a}"].mean for a in "xyz"])
    turned = mean.magnitude() > 1
    assert found["psi_start_rad"].mean == pytest.approx(1.0 + (math.pi if turned else 0.0), abs=2e-3)
    assert found["psi_start_rad"].std < 3e-3
    assert max(found[f"rodrigues_{a}"].std for a in "xyz") < 3e-3


def test_one_frame_has_no_orientation_error():
    rotation = Rotation.from_rotvec([0.1, 0.2, 0.3])
    one = series_quantities([frame(0, rotation)], [0.0])
    assert one.orientation_error is None
    assert any(note.startswith("orientation: 1 good frame") for note in one.notes)
    two = series_quantities([frame(0, rotation), frame(1, rotation)], [0.0, 1.0])
    assert two.orientation_error.against_mean.angle_rad == pytest.approx([0.0, 0.0], abs=1e-7)
