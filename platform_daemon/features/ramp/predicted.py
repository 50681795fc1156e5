"""The threshold that an adopted manufacturing error predicts, by the criterion of the ramp itself."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from drivers.errors import RecordingError
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.rigid_rotor.motions import motions_beside
from platform_daemon.estimation.physics.rigid_rotor.rotor import (
    CoilDrive,
    LostRotorError,
    NoRestError,
    RigidRotor,
    RotorValues,
)
from platform_daemon.features.fit.adopted_rotor import reference_rotor
from platform_daemon.features.fit.known_moment import declared_specimen
from platform_daemon.features.fit.measurement import VoltageMeasurement
from platform_daemon.features.fit.rotor_context import rotor_context
from platform_daemon.features.models.adopted_model import AdoptedModel

from .z_residual import VISIBLE_AM2_PER_S, ZNoise, z_residual

_FIELDS = 16  # at which the motion is computed, then as many again around the threshold
_BELOW, _BEYOND = 0.3, 1.5  # times the lowest and the highest field of the ramp, between which it is sought


@dataclass(frozen=True)
class PredictedThreshold:
    """field_t: T, None: none up to highest_t, the highest field that was computed, T."""

    field_t: float | None
    highest_t: float


def predicted_threshold(
    model: AdoptedModel, shot: Path, noise: ZNoise, main_hz: float | None, lowest_t: float, highest_t: float
) -> PredictedThreshold:
    """The field at which the z residual of the model's rotor passes the visible level.

    The rotor begins at rest, is driven as in the shot with another field, and its z residual is found as that of
    a measured shot, against the noise of the ramp.

    Args:
        model: with a manufacturing error, of the shot's bearing.
        shot: of the ramp, calibrated.
        noise: of its blank shots.
        main_hz: f_nat by the ramp's fits of one angle; the temperature has moved the rotor's since its diagnosis by the
            same share, and m_r with it. None: not known, and taken for that of the diagnosis.
        lowest_t, highest_t: fields of the ramp; the threshold is sought from 0.3 to 1.5 times these.

    Raises:
        RecordingError: the recording or the model does not tell enough.
    """
    recording = open_recording(shot)
    known, specimen = rotor_context(recording, 0), declared_specimen(recording)
    if known is None or known.drive is None or known.rotation is None or specimen is None:
        why = "a threshold is predicted for a drive by a sine of a declared resonator"
        raise RecordingError("no threshold can be predicted", where=str(shot), why=why, remedy="measure with a sine")
    record = VoltageMeasurement.of(recording).signal(0).record
    first, drive, geometry = record.valid_from, known.drive, known.geometry
    rotor, size_t = (
        _at(main_hz, model, reference_rotor(model, specimen, known.rotation)),
        float(np.linalg.norm(drive.field_t)),
    )

    def driven(field_t: float) -> CoilDrive:
        x, y, z = (component * field_t / size_t for component in drive.field_t)
        return replace(drive, field_t=(x, y, z))

    def residual(field_t: float) -> float:
        """Largest z residual, A m^2/s; infinite where the rotor leaves its place."""
        made = [RigidRotor(geometry, rotor, driven(field_t))]
        try:
            (motion,), _ = motions_beside(made, first + noise.samples, noise.rate_hz)
        except (NoRestError, LostRotorError):
            return math.inf
        return math.inf if motion is None else z_residual(motion[:, first:], noise).size_am2_per_s

    most_t = _BEYOND * highest_t
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        below, above = _bracket(np.geomspace(_BELOW * lowest_t, most_t, _FIELDS), pool, residual)
        if above is not None and below is not None:
            below, above = _bracket(np.linspace(below, above, _FIELDS), pool, residual)
    return PredictedThreshold(above, most_t)


def _at(main_hz: float | None, model: AdoptedModel, rotor: RotorValues) -> RotorValues:
    """The rotor with the f_nat of today, and m_r, which goes with it."""
    assert model.rotor is not None
    ratio = model.rotor.ratio.get("f_nat_hz")
    if main_hz is None or ratio is None:
        return rotor
    share = ratio * main_hz / rotor.f_nat_hz
    return rotor.with_numbers({"f_nat_hz": share * rotor.f_nat_hz, "m_r_am2": share * rotor.m_r_am2})


def _bracket(
    fields_t: Array, pool: ThreadPoolExecutor, residual: Callable[[float], float]
) -> tuple[float | None, float | None]:
    """The highest of rising fields before the level is passed, and the first at which it is; None: there is none."""
    sizes: Sequence[float] = list(pool.map(residual, fields_t.tolist()))
    passed = [k for k, size in enumerate(sizes) if size >= VISIBLE_AM2_PER_S]
    if not passed:
        return float(fields_t[-1]), None
    k = passed[0]
    return (float(fields_t[k - 1]) if k else None), float(fields_t[k])
