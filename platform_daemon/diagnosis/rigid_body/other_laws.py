"""Other laws of a jewel's contact in the place of the one that was found.

Near rest a contact's friction is not Coulomb's, and which law it follows there is not known.  In a short window all
laws act alike.  In a longer one the values of one law leave far more than noise with another, since mu, T_f, lambda
and creep of both differ together, and a fit that begins there ends in a valley beside the right one.  A short
window leads into the valley that belongs to the law, and windows that grow stay in it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial

from platform_daemon.diagnosis.shots.thread_pool import beside_each_other
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.physics.rigid_rotor.contact_law import ContactLaw
from platform_daemon.estimation.physics.rigid_rotor.rotor import RotorValues
from platform_daemon.estimation.rotor_fit.fit import CREEP, RotorFit, RotorFitError, fit_rotor, longest_s
from platform_daemon.estimation.rotor_fit.shot import RotorShot
from platform_daemon.estimation.thresholds import THRESHOLDS as FIT_LIMITS

from .starts import Start
from .window_fits import fit_of_window, held_in

_LIMITS = THRESHOLDS.rigid_body


def law_of(values: RotorValues) -> ContactLaw:
    """Of a jewel's contact."""
    return ContactLaw(values.creep_law, values.contact_coupling)


def is_chance(fit: RotorFit) -> bool:
    """What a fit leaves is noise: chi2/dof is one but for chance, so that no other law is needed yet."""
    return fit.chi2_per_dof < 1.0 + _LIMITS.noise_sigma * math.sqrt(2.0 / sum(fit.dof))


def is_alike(fit: RotorFit, start: Start) -> bool:
    """One error with one sign."""
    return fit.defect == start.defect and fit.strength[0] * getattr(start.values, start.defect) > 0.0


def fits_with_other_laws(
    shot: RotorShot, leaders: Sequence[RotorFit], starts: Sequence[Start], pool: Executor, *, whole: bool = False
) -> list[RotorFit]:
    """Fits of one shot with other laws, without those that the leader of their error and sign excludes.

    They are settled as far as comparing them needs.

    Args:
        shot: a window of it.
        leaders: of the same window, with those before it, the best first; none: no fit went so far.
        starts: with the laws, from a short window; where the leader of their error and sign leaves noise, they begin
            from its values, one of each law.
        pool: for the columns of the Jacobian.
        whole: it is the whole ring-down.
    """
    pairs, led = list[tuple[Start, RotorFit | None]](), list[tuple[RotorFit, ContactLaw]]()
    for start in starts:
        leader = next((fit for fit in leaders if is_alike(fit, start)), None)
        if leader is not None and is_chance(leader):
            if any(other is leader and law == law_of(start.values) for other, law in led):
                continue
            led.append((leader, law_of(start.values)))
        pairs.append((start, leader))
    fits = beside_each_other(partial(_fit_with_law, shot, pool, whole), pairs)
    return [fit for fit in fits if fit is not None]


def _fit_with_law(shot: RotorShot, pool: Executor, whole: bool, pair: tuple[Start, RotorFit | None]) -> RotorFit | None:
    start, leader = pair
    most_rise, begun, longest = THRESHOLDS.selection.told_apart_chi2, start.values, longest_s([shot])
    first_s = FIT_LIMITS.rigid_rotor.window_growth * _LIMITS.exchange_window_s
    try:
        if leader is not None and is_chance(leader):
            begun = _led_back(shot, leader, start, pool)
        return fit_rotor(
            [replace(shot, values=begun)],
            start.defect,
            pool,
            first_window_s=min(first_s, FIT_LIMITS.rigid_rotor.predicting_share * longest) if whole else first_s,
            whole=False,
            known=[start.known],
            beside=leader,
            most_rise=most_rise,
            to_beat=math.inf if leader is None else leader.total_chi2 + most_rise * max(1.0, leader.chi2_per_dof),
            predicts=whole,
        )
    except RotorFitError:
        return None


def _led_back(shot: RotorShot, leader: RotorFit, start: Start, pool: Executor) -> RotorValues:
    """The leader's values led into the valley of another law, by windows that grow from the shortest one, in which the
    creep is held.  Raises RotorFitError."""
    values, window_s = leader.values[0].with_numbers(law_of(start.values)._asdict()), _LIMITS.sign_window_s
    creeps = {values.creep_m_per_s, *_LIMITS.creeps_m_per_s}
    tried = [replace(start, values=values.with_numbers({CREEP: creep})) for creep in creeps]
    while window_s <= min(_LIMITS.exchange_window_s, longest_s([shot])):
        held = held_in(shot, window_s)
        tries = [fit_of_window(shot, window_s, held, one, whole=False, pool=pool) for one in tried]
        fits = [fit for fit in tries if fit is not None]
        if not fits:
            raise RotorFitError(f"this law explains no window of {window_s:.3g} s")
        tried = [replace(start, values=min(fits, key=lambda fit: fit.total_chi2).values[0])]
        window_s *= FIT_LIMITS.rigid_rotor.window_growth
    return tried[0].values
