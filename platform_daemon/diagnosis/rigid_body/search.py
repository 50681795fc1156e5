"""The manufacturing errors that one shot cannot exclude: all kinds beside each other, in windows that grow."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass, replace

from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.physics.rigid_rotor.rotor import RotorValues
from platform_daemon.estimation.rotor_fit.fit import (
    RotorFit,
    RotorFitError,
    Stage,
    exchanged,
    fit_rotor,
    longest_s,
    windows_s,
)
from platform_daemon.estimation.rotor_fit.parameters import DEFECTS, Defect
from platform_daemon.estimation.rotor_fit.shot import RotorShot

_LIMITS = THRESHOLDS.rigid_body
_TILT: Defect = "stator_tilt_rad"  # the one with which a search begins


@dataclass(frozen=True)
class _Contestant:
    """An error, with the fit of the last window and the windows before it."""

    fit: RotorFit
    stages: tuple[Stage, ...] = ()

    @property
    def defect(self) -> Defect:
        """Its kind."""
        return defect_of(self.fit)

    def among(self, others: Sequence[_Contestant]) -> bool:
        """One of them is the same kind with the same size."""
        size, std = self.fit.strength
        return any(o.defect == self.defect and abs(o.fit.strength[0] - size) < _LIMITS.same_sigma * std for o in others)


def _begun(shot: RotorShot, pool: Executor) -> list[RotorFit]:
    """Fits of the first tenth of a second with the stator's tilt, of both signs if it tells no sign.

    The frequency goes with the square of the tilt along a bent valley, so that a tilt is free only when those of a grid
    have shown where.  Raises RotorFitError.
    """
    part = replace(shot, samples=shot.samples[:, : shot.count(_LIMITS.sign_window_s)])
    held = _held(shot, _LIMITS.sign_window_s)

    def fitted(values: RotorValues, defect: Defect | None) -> RotorFit | None:
        begun = [replace(part, values=values)]
        try:
            return fit_rotor(begun, defect, pool, first_window_s=math.inf, whole=False, held=held, known=[shot.values])
        except RotorFitError:
            return None

    found = []
    for sign in (1.0, -1.0):
        grid = [fitted(_tilted(shot, sign * size), None) for size in _LIMITS.start_rad]
        near = min((f for f in grid if f is not None), key=total_chi2, default=None)
        free = None if near is None else fitted(near.values[0], _TILT)
        if free is not None:
            found.append(free)
    if not found:
        raise RotorFitError("a short window finds no rotor")
    found.sort(key=total_chi2)
    return [f for f in found if rise(f, found[0]) < _LIMITS.rival_chi2]


def _tilted(shot: RotorShot, tilt_rad: float) -> RotorValues:
    """Start values with a tilt of the stator; of a jewel f_nat is above the main mode by the square of that."""
    jewel = shot.geometry.bearing == "jewel"
    above = 1.0 + (_LIMITS.jewel_softening * tilt_rad**2 if jewel else 0.0)
    return shot.values.with_numbers({_TILT: tilt_rad, "f_nat_hz": above * shot.values.f_nat_hz})


def _held(shot: RotorShot, window_s: float) -> tuple[str, ...]:
    """What a window tells too little of.

    One angle tells a jewel's m_r, and with it the distance, to a thousandth, a thread's only to a tenth; free in a
    short window of a jewel the distance runs away.
    """
    if shot.geometry.bearing == "thread" or window_s > _LIMITS.jewel_distance_from_s:
        return ()
    damped = window_s > _LIMITS.sign_window_s
    return ("distance_m",) if damped else ("distance_m", "lambda_per_s", "side_damping_per_s")


def ranked(shot: RotorShot, pool: Executor) -> list[RotorFit]:
    """Fits of one shot with each defect that it cannot exclude, the best first.  Raises RotorFitError.

    In a short window all of them act alike, and each begins as what the stator's tilt is to first order in its terms.
    Windows grow, and what falls behind in one of them is given up.
    """
    known, starts = shot.values, list[tuple[Defect, RotorValues]]()
    for begun in _begun(shot, pool):
        # m_r of one angle is a tenth off where much of the motion leaves its plane, and with it the distance.
        found = begun.values[0]
        distance_m = shot.geometry.distance_m(found.f_nat_hz, found.m_r_am2)
        known = replace(known, distance_m=distance_m)
        starts.append((_TILT, replace(found, distance_m=distance_m)))
        for other in DEFECTS:
            if other != _TILT:
                with suppress(RotorFitError):
                    (there,) = exchanged(begun, other, pool)
                    starts.append((other, replace(there, distance_m=distance_m)))
    field: list[_Contestant] = []
    longest = longest_s([shot])
    for window_s in windows_s(2.0 * _LIMITS.sign_window_s, longest):
        last = window_s == longest
        held = () if last else _held(shot, window_s)
        runners = [(c.defect, c.fit.values[0], c.stages) for c in field] or [(d, v, ()) for d, v in starts]
        field = []
        for defect, values, stages in runners:
            part = replace(shot, samples=shot.samples[:, : shot.count(window_s)], values=values)
            try:
                fit = fit_rotor([part], defect, pool, first_window_s=math.inf, held=held, whole=last, known=[known])
            except RotorFitError:
                continue
            one = _Contestant(fit, (*stages, Stage(window_s, fit.values, total_chi2(fit))))
            if not one.among(field):
                field.append(one)
        field.sort(key=lambda c: total_chi2(c.fit))
        if not field or field[0].fit.chi2_per_dof > _LIMITS.explained_chi2_per_dof:
            raise RotorFitError(f"no manufacturing error explains the first {window_s:.3g} s")
        field = [c for c in field if rise(c.fit, field[0].fit) < _LIMITS.rival_chi2]
    best: dict[Defect, RotorFit] = {}
    for c in field:
        best.setdefault(c.defect, replace(c.fit, stages=c.stages[:-1]))
    # A kind that went astray in a window begins once more, from the one that explains the whole shot.
    leader = field[0].fit
    for late in with_rivals(leader, [d for d in DEFECTS if d not in best], pool, _LIMITS.late_share * longest):
        if rise(late, leader) < _LIMITS.rival_chi2:
            best[defect_of(late)] = late
    return sorted(best.values(), key=total_chi2)


def with_rivals(
    found: RotorFit, rivals: Sequence[Defect], pool: Executor, first_window_s: float = math.inf
) -> list[RotorFit]:
    """The same shots with other defects, as far as there are such rotors."""
    fits = []
    for rival in rivals:
        try:
            values = exchanged(found, rival, pool)
            begun = [replace(s, values=v) for s, v in zip(found.shots, values, strict=True)]
            fits.append(fit_rotor(begun, rival, pool, first_window_s=first_window_s))
        except RotorFitError:
            continue
    return fits


def rise(fit: RotorFit, best: RotorFit) -> float:
    """Of chi^2 over that of the best fit, in units of what that leaves."""
    return (total_chi2(fit) - total_chi2(best)) / max(1.0, best.chi2_per_dof)


def defect_of(fit: RotorFit) -> Defect:
    """The kind that a fit has."""
    assert fit.defect is not None
    return fit.defect


def total_chi2(fit: RotorFit) -> float:
    """Of all its shots."""
    return sum(fit.chi2)
