"""The manufacturing errors that one shot cannot exclude: all kinds beside each other, in windows that grow."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

from platform_daemon.diagnosis.shots.thread_pool import beside_each_other
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.physics.rigid_rotor.contact_law import ContactLaw
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
from platform_daemon.estimation.thresholds import THRESHOLDS as FIT_LIMITS

from .starts import Start, starts_of

_LIMITS = THRESHOLDS.rigid_body


@dataclass(frozen=True)
class _Contestant:
    """An error, with the fit of the last window, what was known beforehand, and the windows before it."""

    fit: RotorFit
    known: RotorValues
    stages: tuple[Stage, ...] = ()

    @property
    def defect(self) -> Defect:
        """Its kind."""
        return defect_of(self.fit)

    @property
    def law(self) -> ContactLaw:
        """Of a jewel's contact."""
        values = self.fit.values[0]
        return ContactLaw(values.creep_law, values.contact_coupling)

    def stays(self, field: Sequence[_Contestant], window_s: float) -> bool:
        """The window does not exclude it; in a long one a contact's law, which is no name, goes sooner.

        field: the best first.
        """
        same = next(c for c in field if c.defect == self.defect and c.fit.strength[0] * self.fit.strength[0] > 0.0)
        if window_s > _LIMITS.laws_from_s and rise(self.fit, same.fit) > THRESHOLDS.selection.told_apart_chi2:
            return False
        return rise(self.fit, field[0].fit) < FIT_LIMITS.rigid_rotor.rival_chi2

    @property
    def kind(self) -> tuple[Defect, ContactLaw]:
        """Error and law."""
        return self.defect, self.law

    def among(self, others: Sequence[_Contestant]) -> bool:
        """One of them is the same kind with the same size."""
        size, std = self.fit.strength
        return any(o.kind == self.kind and abs(o.fit.strength[0] - size) < _LIMITS.same_sigma * std for o in others)


def _begun(shot: RotorShot, pool: Executor) -> list[tuple[RotorFit, RotorValues]]:
    """Fits of the first tenth of a second with kinds of error, and what was known beforehand of each.

    Raises RotorFitError.
    """
    part = replace(shot, samples=shot.samples[:, : shot.count(_LIMITS.sign_window_s)])
    held = _held(shot, _LIMITS.sign_window_s)
    found: list[tuple[RotorFit, RotorValues]] = []
    for starts in starts_of(part, pool):
        for start in starts:
            begun, known = [replace(part, values=start.values)], [start.known]
            with suppress(RotorFitError):
                fit = fit_rotor(
                    begun, start.defect, pool, first_window_s=math.inf, whole=False, held=held, known=known,
                    to_beat=_to_beat([fit for fit, _ in found], start.defect, start.values),
                )  # fmt: skip
                found.append((fit, start.known))
        if any(fit.chi2_per_dof < _LIMITS.explained_chi2_per_dof for fit, _ in found):
            break
    if not found:
        raise RotorFitError("a short window finds no rotor")
    best = min((fit for fit, _ in found), key=total_chi2)
    return [(fit, known) for fit, known in found if rise(fit, best) < FIT_LIMITS.rigid_rotor.rival_chi2]


def _to_beat(fits: Sequence[RotorFit], defect: Defect, values: RotorValues) -> float:
    """chi^2 of a window above which its fits exclude one that begins with `values`; infinite if none leaves noise."""
    best = min(fits, key=total_chi2, default=None)
    if best is None or best.chi2_per_dof > THRESHOLDS.regression.noise_chi2_per_dof:
        return math.inf
    strength = getattr(values, defect)
    same = [fit for fit in fits if fit.defect == defect and fit.strength[0] * strength > 0.0]
    above = THRESHOLDS.selection.told_apart_chi2 if same else FIT_LIMITS.rigid_rotor.rival_chi2
    return total_chi2(min(same, key=total_chi2, default=best)) + above * max(1.0, best.chi2_per_dof)


def _held(shot: RotorShot, window_s: float) -> tuple[str, ...]:
    """What a window tells too little of.

    One angle tells a jewel's m_r, and with it the distance, to a thousandth, a thread's only to a tenth; free in a
    short window of a jewel the distance runs away.  In the shortest windows so do, for a thread, the damping of
    its centre and the axis of lambda, and for a jewel all losses, which go with its creep.
    """
    first = window_s <= _LIMITS.sign_window_s
    if shot.geometry.bearing == "thread":
        return ("side_damping_per_s", "damping_axis_to_thread") if first else ()
    if first:
        losses = ("lambda_per_s", "side_damping_per_s", "lean_damping_per_s", "creep_m_per_s", "creep_spin_rad_per_s")
        return ("distance_m", *losses)
    return ("distance_m",) if window_s <= _LIMITS.jewel_distance_from_s else ()


def ranked(
    shot: RotorShot, pool: Executor, most_chi2_per_dof: float = _LIMITS.explained_chi2_per_dof
) -> list[RotorFit]:
    """Fits of one shot with each defect, and sign of it, that it cannot exclude, the best first.

    most_chi2_per_dof: beyond which a rotor is of no use, in windows in which nothing is held.

    Raises RotorFitError: also where no rotor explains a window.

    In a short window all of them act alike.  Windows grow, and what falls behind in one of them is given up.  So are
    the laws of a jewel's contact: near rest it is not Coulomb's, and which other one is not known.
    """
    starts = [start for begun, known in _begun(shot, pool) for start in _by_laws(shot, begun, known, pool)]
    field: list[_Contestant] = []
    longest = longest_s([shot])
    for window_s in windows_s(2.0 * _LIMITS.sign_window_s, longest):
        last = window_s == longest
        held = () if last else _held(shot, window_s)
        before = [c.stages for c in field] or [()] * len(starts)
        fits = beside_each_other(partial(_fitted, shot, window_s, held, whole=last, pool=pool), starts)
        field = []
        for fit, start, stages in zip(fits, starts, before, strict=True):
            if fit is None:
                continue
            one = _Contestant(fit, start.known, (*stages, Stage(window_s, fit.values, total_chi2(fit))))
            if not one.among(field):
                field.append(one)
        field.sort(key=lambda c: total_chi2(c.fit))
        most = most_chi2_per_dof if window_s > _LIMITS.laws_from_s else _LIMITS.explained_chi2_per_dof
        if not field or field[0].fit.chi2_per_dof > most:
            raise RotorFitError(f"no manufacturing error explains the first {window_s:.3g} s")
        field = [c for c in field if c.stays(field, window_s)]
        starts = [Start(c.defect, c.fit.values[0], c.known) for c in field]
    best: dict[tuple[Defect, ContactLaw, bool], RotorFit] = {}
    for c in field:
        best.setdefault((*c.kind, c.fit.strength[0] > 0.0), replace(c.fit, stages=c.stages[:-1]))
    # A kind that has not begun or went astray in a window begins from the one that explains the whole shot.
    leader = next(iter(best.values()))
    missing = [d for d in DEFECTS if d not in {d for d, *_ in best}]
    late = beside_each_other(lambda defect: _late(leader, defect, field[0].known, pool), missing)
    near = [f for f in late if f is not None and rise(f, leader) < FIT_LIMITS.rigid_rotor.rival_chi2]
    return sorted([*best.values(), *near], key=total_chi2)


def _by_laws(shot: RotorShot, begun: RotorFit, known: RotorValues, pool: Executor) -> list[Start]:
    """Starts from the fit of a short window: of a jewel with each law of its contact, and its creep that leaves least.

    The short window tells what friction goes with a law; with that of another law its fits go astray in longer ones.
    """
    found = begun.values[0]
    # m_r of one angle is a tenth off where much of the motion leaves its plane, and with it the distance.
    distance_m = shot.geometry.distance_m(found.f_nat_hz, found.m_r_am2)
    starts = []
    jewel = shot.geometry.bearing == "jewel"
    for law in _LIMITS.contact_laws if jewel else _LIMITS.contact_laws[:1]:
        numbers = {"distance_m": distance_m, **law._asdict()}
        start = Start(defect_of(begun), found.with_numbers(numbers), known.with_numbers(numbers))
        if not jewel:
            starts.append(start)
            continue
        creeps = [
            replace(start, values=start.values.with_numbers({"creep_m_per_s": c})) for c in _LIMITS.creeps_m_per_s
        ]
        held = _held(shot, _LIMITS.sign_window_s)
        fits = beside_each_other(partial(_fitted, shot, _LIMITS.sign_window_s, held, whole=False, pool=pool), creeps)
        if some := [fit for fit in fits if fit is not None]:
            starts.append(replace(start, values=min(some, key=total_chi2).values[0]))
    return starts


def _fitted(
    shot: RotorShot, window_s: float, held: Sequence[str], start: Start, *, whole: bool, pool: Executor
) -> RotorFit | None:
    """A fit of a window; None: it finds no rotor."""
    part = replace(shot, samples=shot.samples[:, : shot.count(window_s)], values=start.values)
    try:
        return fit_rotor(
            [part], start.defect, pool, first_window_s=math.inf, held=held, whole=whole, known=[start.known]
        )
    except RotorFitError:
        return None


def _late(leader: RotorFit, missing: Defect, known: RotorValues, pool: Executor) -> RotorFit | None:
    """The whole shot with another error, that begins from the one that explains it; None: it finds no such rotor."""
    try:
        again = replace(leader.shots[0], values=_instead(leader, missing, known, pool))
        first_s = _LIMITS.exchange_window_s
        return fit_rotor([again], missing, pool, first_window_s=first_s, known=[known], beside=leader)
    except RotorFitError:
        return None


def _instead(found: RotorFit, rival: Defect, known: RotorValues, pool: Executor) -> RotorValues:
    """Values with another error, which grows in a short window while the one that was found falls in parts.

    At once it would be far off: f_nat goes with the square of each.  Raises RotorFitError.
    """
    shot, gone = found.shots[0], defect_of(found)
    part = replace(shot, samples=shot.samples[:, : shot.count(_LIMITS.exchange_window_s)], values=found.values[0])
    by = found.strength[0] / _LIMITS.exchange_parts
    fit = fit_rotor([part], gone, pool, first_window_s=math.inf, whole=False, known=[known])
    for _ in range(_LIMITS.exchange_parts):
        (values,) = exchanged(fit, rival, pool, gone=gone, by=min(by, getattr(fit.values[0], gone), key=abs))
        begun = replace(part, values=values)
        fit = fit_rotor([begun], rival, pool, first_window_s=math.inf, whole=False, known=[known])
    return fit.values[0].with_numbers({gone: 0.0})


def total_chi2(fit: RotorFit) -> float:
    """Of all its shots, and of what was known beforehand: for sorting."""
    return fit.total_chi2


def rise(fit: RotorFit, best: RotorFit) -> float:
    """Of chi^2 over that of the best fit, in units of what that leaves."""
    return (total_chi2(fit) - total_chi2(best)) / max(1.0, best.chi2_per_dof)


def defect_of(fit: RotorFit) -> Defect:
    """The kind that a fit has."""
    assert fit.defect is not None
    return fit.defect
