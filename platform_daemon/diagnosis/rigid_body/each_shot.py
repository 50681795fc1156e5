"""Every shot of a series by itself, with what the first one found in common."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import replace

import numpy as np

from platform_daemon.diagnosis.shots.thread_pool import beside_each_other
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.physics.rigid_rotor.rotor import RotorValues
from platform_daemon.estimation.physics.rotation import rodrigues_from_rotation
from platform_daemon.estimation.rotor_fit.fit import RotorFit, RotorFitError, fit_rotor
from platform_daemon.estimation.rotor_fit.parameters import free_parameters
from platform_daemon.estimation.rotor_fit.shot import RotorShot

from .free_start import begun_freely, settled_start
from .search import defect_of, total_chi2

_LIMITS = THRESHOLDS.rigid_body


def each_alone(
    shots: Sequence[RotorShot], first: RotorFit, pool: Executor, *, most_chi2_per_dof: float = math.inf
) -> list[RotorFit]:
    """Fits of each shot alone, that of the first one given.

    most_chi2_per_dof: of any window, above which the error of the first one does not explain a shot.

    Raises RotorFitError.
    """

    def like(shot: RotorShot, fits: Sequence[RotorFit]) -> RotorFit:
        return _like(shot, shots[0], fits, pool, most_chi2_per_dof)

    if all(shot.start != "swing" for shot in shots[1:]):
        return [first, *beside_each_other(lambda shot: like(shot, [first]), shots[1:])]
    fits = [first]
    for shot in shots[1:]:  # what is left of the swing of the one before is where each one begins
        fits.append(like(shot, fits))
    return fits


def _like(
    shot: RotorShot, other: RotorShot, fits: Sequence[RotorFit], pool: Executor, most_chi2_per_dof: float
) -> RotorFit:
    """A shot with what the first one found in common, held; a short window tells with which start values.

    Raises RotorFitError.
    """
    found, n = fits[0], shot.count(_LIMITS.sign_window_s)
    common = [p.name for p in free_parameters(shot.geometry, [defect_of(found)], shot.start) if p.common]
    part = replace(shot, samples=shot.samples[:, :n])
    tried: list[RotorFit] = []
    for values in starts_like(shot, other, fits, pool):
        tried += _short_fits(replace(part, values=values), found, common, pool)
        if tried and _is_noise(tried[-1], found):
            break
    if not tried:
        raise RotorFitError("a short window of a shot finds no rotor like that of the first one")
    begun = replace(shot, values=min(tried, key=total_chi2).values[0])
    return fit_rotor(
        [begun], found.defect, pool, first_window_s=2.0 * _LIMITS.sign_window_s, held=common,
        most_chi2_per_dof=most_chi2_per_dof,
    )  # fmt: skip


def _short_fits(part: RotorShot, found: RotorFit, common: Sequence[str], pool: Executor) -> list[RotorFit]:
    """Fits of a short window; a jewel's first with the friction coefficient held, which goes astray in so short a time
    unless the other values are right already."""
    fits: list[RotorFit] = []
    for held in ([*common, "friction_coefficient"], common) if part.geometry.bearing == "jewel" else (common,):
        begun = replace(part, values=fits[-1].values[0]) if fits else part
        with suppress(RotorFitError):
            fits.append(fit_rotor([begun], found.defect, pool, first_window_s=math.inf, held=held, whole=False))
            if _is_noise(fits[-1], found):
                break
    return fits


def _is_noise(fit: RotorFit, first: RotorFit) -> bool:
    """The short window holds no more than what the first shot's fit leaves."""
    level = 1.0 + _LIMITS.like_first_sigma * math.sqrt(2.0 / sum(fit.dof))
    return fit.chi2_per_dof < level * max(1.0, first.chi2_per_dof)


def starts_like(shot: RotorShot, other: RotorShot, fits: Sequence[RotorFit], pool: Executor) -> Iterator[RotorValues]:
    """Start values: as far from one angle's as those of the first shot; where one angle is wrong, the first shot's
    orientation and moment; at rest, and in the swing in which the shot before ended, whose phase nothing tells; without
    a known drive as the first periods show it."""
    there, v = fits[0].values[0], shot.values
    as_first = replace(
        there,
        f_nat_hz=v.f_nat_hz + there.f_nat_hz - other.values.f_nat_hz,
    ).with_numbers(v.start)
    if other.values.tf_over_i_rad_per_s2 > 0.0 and v.tf_over_i_rad_per_s2 > 0.0:
        ratio = there.tf_over_i_rad_per_s2 / other.values.tf_over_i_rad_per_s2
        as_first = replace(as_first, tf_over_i_rad_per_s2=v.tf_over_i_rad_per_s2 * ratio)
    # One angle may be far off, in every shot alike: how the shots are turned against each other it tells all the same.
    turned_like = v.rotation @ other.values.rotation.T @ there.rotation
    as_one_angle = replace(as_first, rotation=turned_like, m_r_am2=v.m_r_am2 * there.m_r_am2 / other.values.m_r_am2)
    apart = np.linalg.norm(rodrigues_from_rotation(v.rotation.T @ other.values.rotation))
    turned = [as_one_angle, as_first] if apart > _LIMITS.near_rad else [as_one_angle]
    if shot.start == "free":
        yield from (settled_start(shot, begun_freely(shot, begun), pool) for begun in reversed(turned))
        return
    yield from (as_one_angle, as_first)
    size = _left_over_rad(fits[-1]) if shot.start == "swing" else 0.0
    if size < _LIMITS.start_rad:
        return
    for begun in turned:
        for phase in 2.0 * np.pi * np.arange(_LIMITS.start_phases) / _LIMITS.start_phases:
            speed = size * 2.0 * np.pi * v.f_nat_hz * math.sin(phase)
            yield replace(begun, start_angle_rad=float(size * math.cos(phase)), start_speed_rad_per_s=float(speed))


def _left_over_rad(fit: RotorFit) -> float:
    """Amplitude of the swing at the end of a shot; 0 where it has died down, at which the shot was cut off."""
    shot, values = fit.shots[0], fit.values[0]
    count = shot.count(_LIMITS.swing_periods / values.f_nat_hz)
    powers = [
        float(np.sum(part.var(axis=1) - shot.sd**2)) for part in (shot.samples[:, :count], shot.samples[:, -count:])
    ]
    begin, end = (math.sqrt(2.0 * max(power, 0.0)) for power in powers)
    if end < 2.0 * _LIMITS.kept_swing * begin:
        return 0.0
    return end / (values.m_r_am2 * 2.0 * math.pi * values.f_nat_hz)
