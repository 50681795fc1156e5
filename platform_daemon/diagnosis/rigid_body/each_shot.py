"""Every shot of a series by itself, with what the first one found in common."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import replace

import numpy as np

from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.physics.rigid_rotor.rotor import RotorValues
from platform_daemon.estimation.physics.rotation import rodrigues_from_rotation
from platform_daemon.estimation.rotor_fit.fit import RotorFit, RotorFitError, fit_rotor
from platform_daemon.estimation.rotor_fit.parameters import free_parameters
from platform_daemon.estimation.rotor_fit.shot import RotorShot

from .search import defect_of, total_chi2

_LIMITS = THRESHOLDS.rigid_body


def each_alone(shots: Sequence[RotorShot], first: RotorFit, pool: Executor) -> list[RotorFit]:
    """Fits of each shot alone, that of the first one given.  Raises RotorFitError."""
    fits = [first]
    for shot in shots[1:]:
        fits.append(_like(shot, shots[0], fits, pool))
    return fits


def _like(shot: RotorShot, other: RotorShot, fits: Sequence[RotorFit], pool: Executor) -> RotorFit:
    """A shot with what the first one found in common, held; a short window tells with which start values.

    Raises RotorFitError.
    """
    found, n = fits[0], shot.count(_LIMITS.sign_window_s)
    common = [p.name for p in free_parameters(shot.geometry, [defect_of(found)], moving=shot.moving) if p.common]
    tried: list[RotorFit] = []
    for values in _starts(shot, other, fits):
        begun = replace(shot, samples=shot.samples[:, :n], values=values)
        with suppress(RotorFitError):
            tried.append(fit_rotor([begun], found.defect, pool, first_window_s=math.inf, held=common, whole=False))
            if tried[-1].chi2_per_dof < _LIMITS.explained_chi2_per_dof:
                break
    if not tried:
        raise RotorFitError("a short window of a shot finds no rotor like that of the first one")
    begun = replace(shot, values=min(tried, key=total_chi2).values[0])
    return fit_rotor([begun], found.defect, pool, first_window_s=2.0 * _LIMITS.sign_window_s, held=common)


def _starts(shot: RotorShot, other: RotorShot, fits: Sequence[RotorFit]) -> Iterator[RotorValues]:
    """Start values: those of the first shot, with f_nat and friction as far apart as one angle has them; where it has
    another orientation also with that; at rest, and in the swing in which the shot before ended, whose phase nothing
    tells."""
    there, v = fits[0].values[0], shot.values
    as_first = replace(
        there,
        f_nat_hz=v.f_nat_hz + there.f_nat_hz - other.values.f_nat_hz,
        start_angle_rad=0.0,
        start_speed_rad_per_s=0.0,
    )
    if other.values.tf_over_i_rad_per_s2 > 0.0 and v.tf_over_i_rad_per_s2 > 0.0:
        ratio = there.tf_over_i_rad_per_s2 / other.values.tf_over_i_rad_per_s2
        as_first = replace(as_first, tf_over_i_rad_per_s2=v.tf_over_i_rad_per_s2 * ratio)
    yield as_first
    m_r_am2 = v.m_r_am2 * there.m_r_am2 / other.values.m_r_am2
    turned = [as_first]
    if np.linalg.norm(rodrigues_from_rotation(v.rotation.T @ other.values.rotation)) > _LIMITS.near_rad:
        turned.append(replace(as_first, rotation=v.rotation, m_r_am2=m_r_am2))
        yield turned[-1]
    size = _left_over_rad(fits[-1]) if shot.moving else 0.0
    if size < _LIMITS.start_rad:
        return
    for begun in turned:
        for phase in 2.0 * np.pi * np.arange(_LIMITS.start_phases) / _LIMITS.start_phases:
            speed = size * 2.0 * np.pi * v.f_nat_hz * math.sin(phase)
            yield replace(begun, start_angle_rad=float(size * math.cos(phase)), start_speed_rad_per_s=float(speed))


def _left_over_rad(fit: RotorFit) -> float:
    """Amplitude of the swing at the end of a shot."""
    shot, values = fit.shots[0], fit.values[0]
    end = shot.samples[:, -shot.count(_LIMITS.swing_periods / values.f_nat_hz) :]
    power = float(np.sum(end.var(axis=1) - shot.sd**2))
    return math.sqrt(2.0 * max(power, 0.0)) / (values.m_r_am2 * 2.0 * math.pi * values.f_nat_hz)
