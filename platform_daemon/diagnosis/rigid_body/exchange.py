"""Another manufacturing error in the place of the one that was found, for shots in which both may act alike.

At once it would be far off: f_nat goes with the square of each.  In a short window the rival grows while the one that
was found falls in parts; each part begins on the tangent, bent as the part before was.  The short window tells where
the rival's valley lies beside the first one, but not where its floor ends: losses and creep, which only the whole
ring-down tells, wander in it.  A fit of the whole therefore begins as far from the values of the first error's own long
window as the two fits of the short window are apart: to first order, since these two sizes of an error hardly differ.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import replace
from functools import partial

from platform_daemon.diagnosis.shots.thread_pool import beside_each_other
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.physics.rigid_rotor.rotor import RotorValues
from platform_daemon.estimation.rotor_fit.fit import RotorFit, RotorFitError, exchanged, fit_rotor
from platform_daemon.estimation.rotor_fit.parameters import Defect, free_parameters
from platform_daemon.estimation.rotor_fit.shot import RotorShot
from platform_daemon.estimation.thresholds import THRESHOLDS as FIT_LIMITS

_LIMITS = THRESHOLDS.rigid_body


def fits_instead(leader: RotorFit, rivals: Sequence[Defect], pool: Executor) -> list[RotorFit]:
    """Fits of one whole shot with each of some other errors, without those that find no such rotor.

    They are settled only as far as comparing them needs, and what they predict begins with the last window before the
    whole.

    leader: of this shot, in a long window, with the windows before it.
    """
    if not rivals:
        return []
    (shot,), known = leader.shots, leader.known
    part = replace(shot, samples=shot.samples[:, : shot.count(_LIMITS.exchange_window_s)], values=leader.values[0])
    try:
        short = fit_rotor([part], leader.defect, pool, first_window_s=math.inf, whole=False, known=known)
    except RotorFitError:
        return []
    found = beside_each_other(partial(_fit_instead, leader, short, pool=pool), rivals)
    return [fit for fit in found if fit is not None]


def as_far_from(
    at: RotorValues, one: RotorFit, other: RotorFit, *, shot: RotorShot, scale: float | None = None
) -> RotorValues:
    """Values that are as far from others as two fits of one shot with two errors are apart; logarithms, which wander in
    a short window, by one bounded step at most.

    Args:
        at: with the error of `one`.
        one, other: of the same shot.
        shot: the one whose values they are.
        scale: size of the other error over that of `other`; None: as the error of `at` is to that of `one`, if that is
            determined so that both are alike, else 1.
    """
    here, there = one.values[0], other.values[0]
    gone, rival = _defect_of(one), _defect_of(other)
    times = _ratio(getattr(at, gone), getattr(here, gone)) if scale is None else scale
    moved = {
        p.name: p.moved(getattr(at, p.name), p.apart(getattr(here, p.name), getattr(there, p.name)))
        for p in free_parameters(shot.geometry, (), shot.start)
    }
    turn = one.shots[0].rotor(here).rotation.T @ other.shots[0].rotor(there).rotation
    return replace(
        there.with_numbers({**moved, gone: 0.0, rival: times * getattr(there, rival)}),
        rotation=shot.rotor(at).rotation @ turn,
        turn_u_rad=0.0,
        turn_v_rad=0.0,
        turn_w_rad=0.0,
    )


def _fit_instead(leader: RotorFit, short: RotorFit, rival: Defect, *, pool: Executor) -> RotorFit | None:
    """short: of the leader's error in the window of the exchange."""
    (shot,) = leader.shots
    try:
        grown = _grown(short, rival, pool)
        begun = replace(shot, values=as_far_from(leader.values[0], short, grown, shot=shot))
        return fit_rotor(
            [begun], rival, pool, first_window_s=FIT_LIMITS.rigid_rotor.window_growth * _LIMITS.exchange_window_s,
            whole=False, known=leader.known, beside=leader, predicts=False,
        )  # fmt: skip
    except RotorFitError:
        return None


def _grown(short: RotorFit, rival: Defect, pool: Executor) -> RotorFit:
    """A fit of the same window with the other error alone.  Raises RotorFitError."""
    (part,), known = short.shots, short.known
    gone, size = _defect_of(short), short.strength[0]
    part_size = _LIMITS.exchange_part_m if gone == "lateral_displacement_m" else _LIMITS.exchange_part_rad
    parts = min(_LIMITS.exchange_parts, max(1, math.ceil(abs(size) / part_size)))
    free, fit = free_parameters(part.geometry, (rival,), part.start), short
    bent, before = dict.fromkeys((p.name for p in free), 0.0), math.inf  # by which the part before left its tangent
    for _ in range(parts):
        by = min(size / parts, getattr(fit.values[0], gone), key=abs)
        (straight,) = exchanged(fit, rival, pool, gone=gone, by=by)
        again = (by / before) ** 2
        curved = straight.with_numbers({p.name: p.moved(getattr(straight, p.name), again * bent[p.name]) for p in free})
        fit = _first_that_fits(part, (curved, straight), rival, known, pool)
        bent = {p.name: p.apart(getattr(straight, p.name), getattr(fit.values[0], p.name)) for p in free}
        before = by or math.inf
    return fit


def _first_that_fits(
    part: RotorShot, starts: Sequence[RotorValues], defect: Defect, known: Sequence[RotorValues], pool: Executor
) -> RotorFit:
    """Raises RotorFitError."""
    for values in starts[:-1]:
        with suppress(RotorFitError):
            begun = replace(part, values=values)
            return fit_rotor([begun], defect, pool, first_window_s=math.inf, whole=False, known=known)
    begun = replace(part, values=starts[-1])
    return fit_rotor([begun], defect, pool, first_window_s=math.inf, whole=False, known=known)


def _ratio(size: float, short: float) -> float:
    """Of an error's size in a long window over that in a short one; 1 where the short one does not tell it."""
    most = _LIMITS.exchange_most_ratio
    return size / short if abs(short) < most * abs(size) < most**2 * abs(short) and size * short > 0.0 else 1.0


def _defect_of(fit: RotorFit) -> Defect:
    assert fit.defect is not None
    return fit.defect
