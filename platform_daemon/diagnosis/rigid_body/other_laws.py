"""Other laws of a jewel's contact in the place of the one that was found.

Near rest a contact's friction is not Coulomb's, and which law it follows there is not known.  In a short window all
laws act alike.  In a longer one the values of one law leave a million times the noise with another, since mu, T_f,
lambda and creep of both differ together, and a fit that begins there ends in a valley beside the right one.  A short
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
from platform_daemon.estimation.rotor_fit.fit import RotorFit, RotorFitError, fit_rotor
from platform_daemon.estimation.rotor_fit.shot import RotorShot

_LIMITS = THRESHOLDS.rigid_body


def leaves_noise(fit: RotorFit) -> bool:
    """chi2/dof is one but for chance, so that no other law is needed yet."""
    return fit.chi2_per_dof < 1.0 + _LIMITS.noise_sigma * math.sqrt(2.0 / sum(fit.dof))


def fits_with_other_laws(
    shot: RotorShot, leader: RotorFit, without: Sequence[ContactLaw], held: Sequence[str], pool: Executor
) -> list[RotorFit]:
    """Fits of one shot with the leader's error and other laws, but those that the leader excludes.

    They are settled as far as comparing them needs.

    Args:
        shot: with the values at which they begin.
        leader: of the same shot, with the windows before it.
        without: laws that are not tried.
        held: names of parameters that are not free.
        pool: for the columns of the Jacobian.
    """
    if shot.geometry.bearing != "jewel":
        return []
    laws = [law for law in _LIMITS.contact_laws if law not in without]
    fits = beside_each_other(partial(_with_law, shot, leader, held, pool), laws)
    return [fit for fit in fits if fit is not None]


def _with_law(
    shot: RotorShot, leader: RotorFit, held: Sequence[str], pool: Executor, law: ContactLaw
) -> RotorFit | None:
    most_rise = THRESHOLDS.selection.told_apart_chi2
    to_beat = leader.total_chi2 + most_rise * max(1.0, leader.chi2_per_dof)
    begun, known = (v.with_numbers(law._asdict()) for v in (shot.values, leader.known[0]))
    part = replace(shot, values=begun)
    try:
        return fit_rotor(
            [part], leader.defect, pool, first_window_s=_LIMITS.exchange_window_s, held=held, whole=False,
            known=[known], beside=leader, most_rise=most_rise, to_beat=to_beat,
        )  # fmt: skip
    except RotorFitError:
        return None
