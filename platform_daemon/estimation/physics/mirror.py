"""The exact twin of a motion: phi -> -phi together with a half turn about e_u gives the same dm/dt.

No data distinguish the two (psi_start of the twin is 180 degrees on, a bias torque has the other sign). A fit
publishes the one with e_v . x > 0; where e_v is nearly perpendicular to x, noise decides in every shot. What is
said of several shots therefore takes of every shot the twin that lies nearer to a common reference.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.parameters import RODRIGUES
from platform_daemon.estimation.thresholds import THRESHOLDS

from .rotation import nearest_rotation, rodrigues_from_rotation

LIMITS = THRESHOLDS.physics

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


def rotations(rodrigues: Array) -> Rotation:
    """Rotations of vectors (frames, 3) or (3,)."""
    from scipy.spatial.transform import Rotation  # here, because every command imports this module and few need it

    return Rotation.from_rotvec(rodrigues)


def mirror_images(turned: Rotation) -> Rotation:
    """The same motions with phi -> -phi."""
    return turned * rotations(np.array([math.pi, 0.0, 0.0]))


def nearest_mirror_images(rodrigues: Array, reference: Array) -> tuple[Array, np.ndarray]:
    """Of vectors (frames, 3) the twins nearest to a reference (3,), and which are not the ones given, bool (frames,).

    A rotation by nearly 180 degrees has two names, v and v shortened by 2 pi: of these, too, the nearer one.
    """
    blocks = np.array_split(
        np.asarray(rodrigues, dtype=np.float64), math.ceil(len(rodrigues) / LIMITS.mean_rotations) or 1
    )
    found = [_nearest(block, reference) for block in blocks]
    return np.concatenate([vectors for vectors, _ in found]), np.concatenate([turned for _, turned in found])


def _nearest(rodrigues: Array, reference: Array) -> tuple[Array, np.ndarray]:
    given, centre = rotations(rodrigues), rotations(reference)
    others = mirror_images(given)
    turned = (centre.inv() * others).magnitude() < (centre.inv() * given).magnitude()
    vectors = np.where(turned[:, None], others.as_rotvec(), rodrigues)
    return _named_near(vectors, np.asarray(reference, dtype=np.float64)), turned


def mean_over_mirror_images(rodrigues: Array) -> Array:
    """Chordal mean on SO(3) of vectors (frames, 3), each by its twin nearest to that mean; (3,), with e_v . x >= 0.

    It starts from what twins share: the direction of e_u and the line along e_v.
    """
    matrices = rotations(rodrigues).as_matrix()
    along, across = matrices[:, :, 1], matrices[:, :, 0].mean(axis=0)
    mean = rodrigues_from_rotation(nearest_rotation(np.linalg.eigh(along.T @ along)[1][:, -1], across))
    before: np.ndarray | None = None
    for _ in range(LIMITS.mean_rounds):
        nearest, turned = nearest_mirror_images(rodrigues, mean)
        if before is not None and np.array_equal(turned, before):
            break
        mean, before = rotations(nearest).mean().as_rotvec(), turned
    chosen = rotations(mean)
    return np.asarray((mirror_images(chosen) if chosen.as_matrix()[0, 1] < 0.0 else chosen).as_rotvec())


def on_one_branch(frames: Sequence[Mapping[str, float]]) -> tuple[list[dict[str, float]], Array | None]:
    """Public parameters of several frames, each as those of its twin nearest to their mean orientation (3,), and that.

    Frames without orientation stay as they are: nothing distinguishes their twins; None if all are.
    """
    seen = [k for k, values in enumerate(frames) if RODRIGUES[0] in values]
    folded = [dict(values) for values in frames]
    if not seen:
        return folded, None
    vectors = np.array([[frames[k][name] for name in RODRIGUES] for k in seen])
    mean = mean_over_mirror_images(vectors)
    nearest, turned = nearest_mirror_images(vectors, mean)
    for k, vector, is_turned in zip(seen, nearest.tolist(), turned.tolist(), strict=True):
        folded[k] |= _mirrored(folded[k]) if is_turned else {}
        folded[k] |= zip(RODRIGUES, vector, strict=True)
    return folded, mean


def _mirrored(values: Mapping[str, float]) -> dict[str, float]:
    """What phi -> -phi changes in addition to the orientation."""
    from .torques import OF_OTHER_SIGN_IN_MIRROR  # here, because its compiler takes half a second, and few frames turn

    signs = {name: -values[name] for name in OF_OTHER_SIGN_IN_MIRROR if name in values}
    return signs | {"psi_start_rad": (values["psi_start_rad"] + math.pi) % (2.0 * math.pi)}


def _named_near(vectors: Array, reference: Array) -> Array:
    """Vectors (frames, 3), each by that of its names that lies nearer to the reference (3,)."""
    angle = np.linalg.norm(vectors, axis=1, keepdims=True)
    other = vectors * (1.0 - 2.0 * np.pi / np.where(angle > 0.0, angle, np.inf))
    nearer = np.linalg.norm(other - reference, axis=1) < np.linalg.norm(vectors - reference, axis=1)
    return np.where(nearer[:, None], other, vectors)
