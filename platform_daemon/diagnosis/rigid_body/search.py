"""The manufacturing errors that one shot cannot exclude: all kinds beside each other, in windows that grow."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from platform_daemon.diagnosis.shots.thread_pool import beside_each_other
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.physics.rigid_rotor.contact_law import ContactLaw
from platform_daemon.estimation.physics.rigid_rotor.rotor import RotorValues
from platform_daemon.estimation.rotor_fit.fit import (
    CREEP,
    RotorFit,
    RotorFitError,
    Stage,
    fit_rotor,
    longest_s,
    windows_s,
)
from platform_daemon.estimation.rotor_fit.parameters import DEFECTS, Defect
from platform_daemon.estimation.rotor_fit.shot import RotorShot
from platform_daemon.estimation.thresholds import THRESHOLDS as FIT_LIMITS

from .exchange import fits_instead
from .other_laws import fits_with_other_laws, is_alike, is_chance, law_of
from .starts import Start, starts_of
from .window_fits import fit_of_window, held_in

_LIMITS = THRESHOLDS.rigid_body
_RIVAL_CHI2 = FIT_LIMITS.rigid_rotor.rival_chi2


@dataclass(frozen=True)
class Contestant:
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
        return law_of(self.fit.values[0])

    @classmethod
    def after(cls, stages: tuple[Stage, ...], window_s: float, fit: RotorFit, known: RotorValues) -> Contestant:
        """One that went through some windows before that of its fit."""
        return cls(fit, known, (*stages, Stage(window_s, fit.values, total_chi2(fit))))

    def stays(self, field: Sequence[Contestant], window_s: float) -> bool:
        """The window does not exclude it; in a long one a contact's law, which is no name, goes sooner.

        field: the best first.
        """
        same = next(c for c in field if c.defect == self.defect and c.fit.strength[0] * self.fit.strength[0] > 0.0)
        if window_s > _LIMITS.laws_from_s and rise(self.fit, same.fit) > THRESHOLDS.selection.told_apart_chi2:
            return False
        return rise(self.fit, field[0].fit) < _RIVAL_CHI2

    @property
    def kind(self) -> tuple[Defect, ContactLaw]:
        """Error and law."""
        return self.defect, self.law

    def alike(self, other: Contestant) -> bool:
        """Both are the same kind with the same sign."""
        return self.kind == other.kind and self.fit.strength[0] * other.fit.strength[0] > 0.0

    def among(self, others: Sequence[Contestant]) -> bool:
        """One of them is the same kind with the same size."""
        size, std = self.fit.strength
        return any(o.kind == self.kind and abs(o.fit.strength[0] - size) < _LIMITS.same_sigma * std for o in others)


def _begun(shot: RotorShot, pool: Executor) -> list[tuple[RotorFit, RotorValues]]:
    """Fits of the first tenth of a second with kinds of error, and what was known beforehand of each.

    Raises RotorFitError.
    """
    part = replace(shot, samples=shot.samples[:, : shot.count(_LIMITS.sign_window_s)])
    held = held_in(shot, _LIMITS.sign_window_s)
    # Where the state at the start is not known, side modes and orientation are told apart in windows that grow.
    first_s = _LIMITS.first_free_window_s if shot.start == "free" else math.inf
    found: list[tuple[RotorFit, RotorValues]] = []
    for starts in starts_of(part, pool):
        for start in starts:
            begun, known = [replace(part, values=start.values)], [start.known]
            noise = [fit for fit, _ in found if fit.chi2_per_dof < THRESHOLDS.regression.noise_chi2_per_dof]
            with suppress(RotorFitError):
                fit = fit_rotor(
                    begun, start.defect, pool, first_window_s=first_s, whole=False, held=held, known=known,
                    to_beat=_to_beat(noise, start), predicts=False,
                )  # fmt: skip
                found.append((fit, start.known))
        if any(fit.chi2_per_dof < _LIMITS.explained_chi2_per_dof for fit, _ in found):
            break
    if not found:
        raise RotorFitError("a short window finds no rotor")
    one_by_one = sorted((Contestant(fit, known) for fit, known in found), key=lambda c: total_chi2(c.fit))
    apart = [c for k, c in enumerate(one_by_one) if not any(c.alike(o) and c.among([o]) for o in one_by_one[:k])]
    return [(c.fit, c.known) for c in apart if rise(c.fit, apart[0].fit) < _RIVAL_CHI2]


def _to_beat(fits: Sequence[RotorFit], start: Start) -> float:
    """chi^2 of a window above which its fits exclude one that begins with `start`; infinite without fits."""
    best = min(fits, key=total_chi2, default=None)
    if best is None:
        return math.inf
    strength = getattr(start.values, start.defect)
    same = [fit for fit in fits if fit.defect == start.defect and fit.strength[0] * strength > 0.0]
    above = THRESHOLDS.selection.told_apart_chi2 if same else _RIVAL_CHI2
    return total_chi2(min(same, key=total_chi2, default=best)) + above * max(1.0, best.chi2_per_dof)


def ranked(
    shot: RotorShot, pool: Executor, most_chi2_per_dof: float = _LIMITS.explained_chi2_per_dof
) -> list[RotorFit]:
    """Fits of one shot with each defect, and sign of it, that it cannot exclude, the best first.

    most_chi2_per_dof: beyond which a rotor is of no use, in windows in which nothing is held.

    Raises RotorFitError: also where no rotor explains a window.

    In a short window all of them act alike.  Windows grow, and what falls behind in one of them is given up.  A kind
    that has not begun or went astray in a window begins from the best one of the last window but one, beside the last
    window of that; where the last window excludes it, once more from the one that is best then, and all others from a
    late one that leaves less than the best.  Laws of a jewel's contact, which are no names, compete in short windows;
    see `contest` for long ones.
    """
    starts = [start for begun, known in _begun(shot, pool) for start in _by_laws(shot, begun, known, pool)]
    field, spared = list[Contestant](), list[Start]()
    *growing, longest = windows_s(2.0 * _LIMITS.sign_window_s, longest_s([shot]))
    for window_s in growing:
        field, spared = contest(shot, window_s, starts, spared, most_chi2_per_dof, pool)
        starts = [Start(c.defect, c.fit.values[0], c.known, c.stages) for c in field]
    begun = field[0] if field else None
    early = _missing(field) if field else []
    tasks: list[Callable[[], Any]] = [
        partial(contest, shot, longest, starts, spared, most_chi2_per_dof, pool, whole=True),
        partial(_late, shot, field, early, pool),
    ]
    (field, _), late = beside_each_other(lambda task: task(), tasks, at_once=len(tasks))
    best: dict[tuple[Defect, ContactLaw, bool], RotorFit] = {}
    for c in field:
        best.setdefault((*c.kind, c.fit.strength[0] > 0.0), replace(c.fit, stages=c.stages[:-1]))
    near = [f for f in late if rise(f, field[0].fit) < _RIVAL_CHI2]
    # Where the last window excludes the former best one, what began from that proves nothing by being far off.
    same = begun is not None and any(begun.alike(c) for c in field)
    tried = {f.defect for f in near} | (set(early) if same else set())
    astray = [defect for defect in _missing(field) if defect not in tried]
    near += [f for f in _late(shot, field, astray, pool) if rise(f, field[0].fit) < _RIVAL_CHI2]
    near += once_more_from_late(shot, field[0], near, pool)
    return _apart([*best.values(), *near])


def _apart(fits: Sequence[RotorFit]) -> list[RotorFit]:
    """Those that the best does not exclude, of one error with one sign and law the best, the best first."""
    found = list[Contestant]()
    for fit in sorted(fits, key=total_chi2):
        one = Contestant(fit, fit.known[0])
        if not any(one.alike(other) for other in found):
            found.append(one)
    return [c.fit for c in found if rise(c.fit, found[0].fit) < _RIVAL_CHI2]


def once_more_from_late(shot: RotorShot, found: Contestant, late: Sequence[RotorFit], pool: Executor) -> list[RotorFit]:
    """Fits with the other errors that begin from a late one, where that shows that `found` is no minimum: an error that
    acts like it leaves much less."""
    best = min(late, key=total_chi2, default=found.fit)
    if rise(found.fit, best) < THRESHOLDS.selection.told_apart_chi2:
        return []
    leader = Contestant(best, found.known, best.stages)
    return _late(shot, [leader], [defect for defect in DEFECTS if defect != best.defect], pool)


def _late(shot: RotorShot, field: Sequence[Contestant], missing: Sequence[Defect], pool: Executor) -> list[RotorFit]:
    """The whole shot with other errors, that begin from the best of a field; none if that finds no such rotor."""
    if not field:
        return []
    return fits_instead(replace(field[0].fit, shots=(shot,), stages=field[0].stages), missing, pool)


def _missing(field: Sequence[Contestant]) -> list[Defect]:
    """Kinds of error that none of them has."""
    there = {c.defect for c in field}
    return [defect for defect in DEFECTS if defect not in there]


def _fits(
    shot: RotorShot, window_s: float, starts: Sequence[Start], pool: Executor, *, whole: bool = False
) -> list[RotorFit | None]:
    """Of a window with each start, the others beside each other.

    In a long window the first one tells when others are of no use; in a short one they are cheap, and their valleys
    bend so much that a small step says nothing of those that follow.  Beside the first one the others need only be
    settled as far as comparing them takes, also in the last window: `made_whole` settles the one that is named.
    """
    if not starts:
        return []
    held = () if whole else held_in(shot, window_s)
    fitted = partial(fit_of_window, shot, window_s, held, whole=whole, pool=pool)
    if window_s <= _LIMITS.laws_from_s:
        return beside_each_other(fitted, starts)
    first = fitted(starts[0])
    if first is None:
        return [None, *beside_each_other(fitted, starts[1:])]
    best: RotorFit = first

    def other(start: Start) -> RotorFit | None:
        return fitted(start, to_beat=_to_beat([best], start), whole=False)

    return [first, *beside_each_other(other, starts[1:])]


def contest(
    shot: RotorShot,
    window_s: float,
    starts: Sequence[Start],
    spared: Sequence[Start],
    most_chi2_per_dof: float,
    pool: Executor,
    *,
    whole: bool = False,
) -> tuple[list[Contestant], list[Start]]:
    """Those that a window does not exclude, the best first, and laws of a jewel's contact that it did not need.

    In a long window fits with each law are slow.  Starts that differ by nothing else from one before them are spared
    there while the best leaves noise, and with an error and sign that the window excludes they are given up.  In the
    whole window they are tried all the same.

    spared: laws that the windows before did not need.

    Raises RotorFitError: no rotor explains the window.
    """
    tried, spare = list[Start](), list(spared)
    for start in starts:
        needless = window_s > _LIMITS.laws_from_s and any(_differ_by_law(start, other) for other in tried)
        (spare if needless else tried).append(start)
    field = _sorted(
        Contestant.after(start.stages, window_s, fit, start.known)
        for fit, start in zip(_fits(shot, window_s, tried, pool, whole=whole), tried, strict=True)
        if fit is not None
    )
    if field:
        spare = [start for start in spare if any(is_alike(c.fit, start) for c in field if c.stays(field, window_s))]
    if spare and (whole or not field or not is_chance(field[0].fit)):
        part = replace(shot, samples=shot.samples[:, : shot.count(window_s)])
        leaders = [replace(c.fit, stages=c.stages) for c in field]
        fits = fits_with_other_laws(part, leaders, spare, pool, whole=whole)
        field = _sorted([*field, *(Contestant.after(fit.stages, window_s, fit, fit.known[0]) for fit in fits)])
        spare = []
    most = most_chi2_per_dof if window_s > _LIMITS.laws_from_s else _LIMITS.explained_chi2_per_dof
    if not field or field[0].fit.chi2_per_dof > most:
        raise RotorFitError(f"no manufacturing error explains the first {window_s:.3g} s")
    apart = [c for k, c in enumerate(field) if not c.among(field[:k])]
    return [c for c in apart if c.stays(apart, window_s)], spare


def _sorted(field: Iterable[Contestant]) -> list[Contestant]:
    """The best first."""
    return sorted(field, key=lambda c: total_chi2(c.fit))


def _differ_by_law(one: Start, other: Start) -> bool:
    """One error with one sign, and two laws of a jewel's contact."""
    sizes = [getattr(start.values, one.defect) for start in (one, other)]
    return one.defect == other.defect and sizes[0] * sizes[1] > 0.0 and law_of(one.values) != law_of(other.values)


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
        creeps = [replace(start, values=start.values.with_numbers({CREEP: c})) for c in _LIMITS.creeps_m_per_s]
        held = held_in(shot, _LIMITS.sign_window_s)
        fits = beside_each_other(
            partial(fit_of_window, shot, _LIMITS.sign_window_s, held, whole=False, pool=pool), creeps
        )
        if some := [fit for fit in fits if fit is not None]:
            starts.append(replace(start, values=min(some, key=total_chi2).values[0]))
    return starts


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
