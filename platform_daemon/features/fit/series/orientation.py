"""How far orientations lie apart: the error angle of tab:model_params_fit_result, over the frames of a series.

Orientations are Rodrigues vectors, rad, as the fit publishes them. Vectors of length near pi that look different can
be the same orientation; angles between rotations do not care. Nor do they care which of its two twins a fit publishes
(estimation/physics/mirror.py): an error is the angle to the nearer one.
"""

from __future__ import annotations

import numpy as np

from platform_daemon.core.schemas.derived import OrientationDeviation
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.mirror import mean_over_mirror_images, mirror_images, rotations


def error_angle(rodrigues: Array, reference: Array) -> Array:
    """Rotation angle of R_ref^T R in rad for the nearer twin R, (...) for vectors (..., 3); exact for tiny angles."""
    one, other = np.asarray(rodrigues, dtype=np.float64), np.asarray(reference, dtype=np.float64)
    given, back = rotations(one.reshape(-1, 3)), rotations(other).inv()
    angle = np.minimum((back * given).magnitude(), (back * mirror_images(given)).magnitude())
    return np.asarray(angle, dtype=np.float64).reshape(one.shape[:-1])


def mean_orientation(rodrigues: Array) -> Array:
    """Chordal mean on SO(3) of vectors (frames, 3): the rotation nearest to all in the sum of squared chords, (3,).

    Every frame counts by its nearer twin; of the mean's twins it is the one with e_v . x >= 0.
    """
    return mean_over_mirror_images(_frames(rodrigues))


def best_orientation(rodrigues: Array, r2: Array) -> Array:
    """The orientation of the fit with the highest R2 (ssec:primary_results), (3,); r2: (frames,), NaN never wins."""
    quality = np.asarray(r2, dtype=np.float64)
    vectors = _frames(rodrigues)
    if quality.shape != (len(vectors),) or np.all(np.isnan(quality)):
        raise ValueError(f"{len(vectors)} orientations need as many R2, not all NaN: {quality!r}")
    return vectors[int(np.nanargmax(quality))]


def orientation_spread(rodrigues: Array, reference: Array | None = None) -> OrientationDeviation:
    """Error angles of vectors (frames, 3) against a reference (3,); None: against their own chordal mean.

    The paper's reference is best_orientation of the D30 dataset, for both its datasets.
    """
    vectors = _frames(rodrigues)
    chosen = mean_orientation(vectors) if reference is None else np.asarray(reference, dtype=np.float64)
    angle = error_angle(vectors, chosen)
    return OrientationDeviation(
        reference_rodrigues_rad=tuple(chosen.tolist()),
        angle_rad=tuple(angle.tolist()),
        mean_rad=float(np.mean(angle)),
        std_rad=float(np.std(angle, ddof=1)) if angle.size > 1 else None,
    )


def _frames(rodrigues: Array) -> Array:
    """(frames, 3), at least one frame, finite."""
    vectors = np.asarray(rodrigues, dtype=np.float64)
    if vectors.ndim != 2 or vectors.shape[1] != 3 or len(vectors) == 0:
        raise ValueError(f"orientations must have shape (frames, 3) with at least one frame, not {vectors.shape}")
    if not np.all(np.isfinite(vectors)):
        raise ValueError("orientations must be finite: leave refused frames out")
    return vectors
