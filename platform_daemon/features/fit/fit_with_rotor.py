"""Fits with an adopted manufacturing error: a rotor of five degrees of freedom in the place of one angle."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from drivers.errors import RecordingError
from platform_daemon.core.recordings.recording import Recording
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.parameters import RODRIGUES, Estimate
from platform_daemon.estimation.physics.rigid_rotor.rotor import RotorValues
from platform_daemon.estimation.physics.rotation import rodrigues_from_rotation, rotation_from_rodrigues
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.result import FitResult
from platform_daemon.estimation.rotor_fit.fit import RotorFit, RotorFitError, fit_rotor, with_errors_of_held
from platform_daemon.estimation.rotor_fit.parameters import HELD_WITH_A_DEFECT
from platform_daemon.estimation.rotor_fit.shot import RotorContext, RotorShot
from platform_daemon.features.models.adopted_model import AdoptedModel
from platform_daemon.features.models.schema import AdoptedRotorRecord

from .adopted_rotor import adopted_values, covariance_of_adopted
from .rotor_context import assumed_rotor_context

Refinement = Callable[[RingDownRecord, NoiseModel | None, FitResult], FitResult]
HOLDABLE = ("f_nat_hz", "m_r_am2", "lambda_per_s", "tf_over_i_rad_per_s2")
"""Parameters of one angle that the rotor has too."""
TURNS = ("turn_u_rad", "turn_v_rad", "turn_w_rad")
"""The orientation in the rotor's own frame."""
_TURN_STEP_RAD = 1e-6


def unchanged(record: RingDownRecord, noise: NoiseModel | None, fit: FitResult) -> FitResult:
    """The refinement of a model of one angle: none."""
    return fit


def with_rotor(recording: Recording, frame: int, model: AdoptedModel, fixed: Mapping[str, float]) -> Refinement:
    """What makes of a frame's fit of one angle that of the rotor, over the same window.

    fixed: of HOLDABLE, values that the fit holds.  Raises RecordingError if the recording has no calibration.
    """
    known, error = assumed_rotor_context(recording, frame, model.base), model.rotor
    assert error is not None
    if known is None or recording.calibration is None:
        raise RecordingError(
            f"{model.label} cannot be used here",
            where=f"{recording.path}: frame {frame}",
            why="a rotor with a manufacturing error takes a calibration, and the geometry of a thread or a jewel",
            remedy=f"give the calibration, or fit {model.base}",
        )
    return lambda record, noise, start: _refined(record, noise, start, known, error, fixed)


def _refined(
    record: RingDownRecord,
    noise: NoiseModel | None,
    start: FitResult,
    known: RotorContext,
    error: AdoptedRotorRecord,
    fixed: Mapping[str, float],
) -> FitResult:
    if start.verdict != "good" or start.window_s is None:
        return start
    if noise is None:
        return FitResult("refused", reason="noise: it cannot be measured, and the rotor's fit is weighted by it")
    began = time.perf_counter()
    shot = _shot(record, noise, start, known, error)
    shot = replace(shot, values=shot.values.with_numbers(fixed))
    held = (*HELD_WITH_A_DEFECT, error.parameter, *fixed)
    try:
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            fit = fit_rotor([shot], None, pool, held=held)
            if error.covariance is not None:
                fit = with_errors_of_held(
                    fit, *covariance_of_adopted(error.covariance, drawn=known.geometry.drawn), pool
                )
    except RotorFitError as failed:
        return FitResult("refused", reason=f"rotor: {failed} ({error.id} {error.strength:.4g} is held)")
    found = _result(start, fit, error)
    return replace(found, notes=(*found.notes, *known.assumed), seconds=start.seconds + time.perf_counter() - began)


def _shot(
    record: RingDownRecord, noise: NoiseModel, start: FitResult, known: RotorContext, error: AdoptedRotorRecord
) -> RotorShot:
    """The window of the fit of one angle, with start values as far from that fit as in the diagnosis."""
    found = {name: each.value for name, each in start.parameters.items()}
    at = {name: found[name] * error.ratio.get(name, 1.0) for name in HOLDABLE if name in found}
    turned = rotation_from_rodrigues(np.array([found[n] for n in RODRIGUES]))
    rotation = known.facing(turned)
    values = adopted_values(error, at, rotation, drawn=known.geometry.drawn)
    if known.drive is None:
        side, motion = -1.0 if known.turned(turned) else 1.0, start.ring_down()
        phi, per_turn = (each[-1] for each in motion.motion(record.valid_from + 1, record.dt_s))
        speed = float(per_turn) * motion.dynamics.w
        values = replace(values, start_angle_rad=side * float(phi), start_speed_rad_per_s=side * speed)
    samples = record.valid[:, : start.samples]
    return RotorShot(
        samples=samples,
        rate_hz=record.sampling_rate_hz,
        sd=noise.sd,
        geometry=known.geometry,
        drive=known.drive_from(record.valid_from * record.dt_s),
        values=values,
        declared=rotation if known.rotation is None else known.rotation,
        start=known.start,
    )


def _result(start: FitResult, fit: RotorFit, error: AdoptedRotorRecord) -> FitResult:
    """The published form; phi_max and psi, labels of the one-angle motion, stay those of its fit."""
    (shot,), (values,) = fit.shots, fit.values
    names, covariance = public_errors(fit)
    rodrigues = rodrigues_from_rotation(shot.rotor(values).rotation)
    numbers = {**vars(values), **dict(zip(RODRIGUES, rodrigues, strict=True))}
    std = dict(zip(names, np.sqrt(np.diag(covariance)), strict=True))
    own = {name: Estimate(float(numbers[name]), float(std[name])) for name in names}
    model, _ = shot.rotor(values).dm_dt(shot.samples.shape[1], shot.rate_hz)
    left = shot.samples - model
    left = left - left.mean(axis=1, keepdims=True)
    squares = float(np.sum(left**2))
    by_channel = np.mean((left / shot.sd[:, None]) ** 2, axis=1)
    held = f"{error.id} {error.strength:.6g}"
    of_held = "without" if error.covariance is None else "with"
    return replace(
        start,
        parameters={name: own.get(name, old) for name, old in start.parameters.items()},
        covariance=covariance,
        covariance_names=names,
        notes=(
            *start.notes,
            f"a rotor of five degrees of freedom with {held} held; errors are {of_held} those of what is held; "
            "phi_max and psi are those of one angle",
        ),
        warnings=(),
        r2=1.0 - squares / float(np.sum((shot.samples - shot.samples.mean(axis=1, keepdims=True)) ** 2)),
        nrmse=float(np.sqrt(squares / np.sum(shot.samples**2))),
        chi2_per_dof=fit.chi2_per_dof,
        chi2_per_dof_by_channel=tuple(by_channel.tolist()),
        whiteness_by_channel=None,
        condition=None,
        inseparable=(),
        fitted=None,
    )


def public_errors(fit: RotorFit) -> tuple[tuple[str, ...], Array]:
    """Of a fit of one shot: public names of the main mode and the orientation that are free, and their covariance."""
    (shot,), (values,), (places,) = fit.shots, fit.values, fit.places
    names = [name for name in HOLDABLE if name in places]
    covariance = fit.covariance[np.ix_(*[[places[n] for n in (*names, *TURNS)]] * 2)]
    slope = np.eye(len(covariance))
    slope[-3:, -3:] = _rodrigues_by_turns(shot, values)
    return (*names, *RODRIGUES), slope @ covariance @ slope.T


def _rodrigues_by_turns(shot: RotorShot, values: RotorValues) -> Array:
    """Derivative (3, 3) of the orientation's vector by the turns about u, v, w."""
    rows = []
    for name in TURNS:
        low, high = (
            rodrigues_from_rotation(
                shot.rotor(values.with_numbers({name: getattr(values, name) + sign * _TURN_STEP_RAD})).rotation
            )
            for sign in (-1.0, 1.0)
        )
        rows.append((high - low) / (2.0 * _TURN_STEP_RAD))
    return np.array(rows).T
