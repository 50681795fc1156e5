"""The effects that the declared model lacks: the candidates of such shots, and the search among them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial

import numpy as np

from platform_daemon.estimation.physics.models import RingDownModel

from .effects.additive import zero_drifts
from .effects.effect import Candidate
from .effects.kick import KICK
from .effects.reading import reading_candidates
from .effects.receiver import receiver_candidates
from .effects.torque import (
    drift_candidate,
    pendulum_candidates,
    settling_candidate,
    stribeck_candidates,
    torque_candidates,
)
from .regression.hypothesis import Hypothesis
from .regression.joint_fit import JointFit, fit_jointly
from .regression.prediction import unpredicted
from .selection.component_search import with_tone_free_noise
from .selection.data_integrity import DataDefect, gap_filled
from .selection.kick_search import kicks
from .selection.select_effects import select_effects
from .selection.stepwise import ProgressCallback, Selection
from .shots.shot import PreparedShot
from .thresholds import THRESHOLDS


def selected_effects(
    prepared: list[PreparedShot],
    model: RingDownModel,
    local: Sequence[DataDefect],
    progress: ProgressCallback,
    pool: Executor,
    on_larger_sets: Callable[[JointFit], None] = lambda base: None,
) -> tuple[Selection, list[DataDefect]]:
    """The selected effects, and clock gaps that only a model of the motion shows.

    A missing effect looks like such gaps, and they look like a missing effect: both are tried, and the smaller residual
    decides.

    on_larger_sets: called with the declared model's fit once single effects do not suffice.
    """
    found = _effects(prepared, model, progress, pool, on_larger_sets)
    filled, gaps = gap_filled(prepared, model, pool, local)
    if gaps:
        refilled = _effects(filled, model, progress, pool)
        return (refilled, gaps) if _leaves_less(refilled, found) else (found, [])
    best = found.best
    if not best.hypothesis.torques:
        return found, []
    known = [replace(s, state=best.full_state(k)) for k, s in enumerate(best.prepared)]
    filled, gaps = gap_filled(known, best.hypothesis.augmented, pool, local)
    if not gaps:
        return found, []
    refilled = _effects(
        [replace(m, state=s.state) for m, s in zip(filled, prepared, strict=True)], model, progress, pool
    )
    return (refilled, gaps) if _leaves_less(refilled, found) else (found, [])


def _leaves_less(one: Selection, other: Selection) -> bool:
    """True if one, with gaps, leaves only noise, and significantly less than the other, in units of this noise.

    Where the other needs a kick that one does not, as much is enough: a lost sample changes the phase at an instant as
    a kick does, with a whole number in place of a free strength.
    """
    if one.best.chi2_per_dof > THRESHOLDS.regression.noise_chi2_per_dof:
        return False
    left = [sum(float(np.sum(unpredicted(s.best, k) ** 2)) for k in range(len(s.best.linear))) for s in (one, other)]
    limits = THRESHOLDS.selection
    in_place = _count_of_kicks(one) < _count_of_kicks(other)
    least = -limits.told_apart_chi2 if in_place else limits.model_gap_chi2
    return left[0] * (1.0 + least / one.best.dof) < left[1]


def _count_of_kicks(found: Selection) -> int:
    return sum(c.effect is KICK for c in found.best.hypothesis.effects)


def _effects(
    prepared: Sequence[PreparedShot],
    model: RingDownModel,
    progress: ProgressCallback,
    pool: Executor,
    on_larger_sets: Callable[[JointFit], None] = lambda base: None,
) -> Selection:
    """The joint fit of the declared model, and the effects that it lacks."""
    base = declared_fit(prepared, model, pool)
    return select_effects(base, candidates_for(base), pool, progress, partial(on_larger_sets, base))


def declared_fit(prepared: Sequence[PreparedShot], model: RingDownModel, pool: Executor) -> JointFit:
    """The joint fit of the declared model, its noise without the tones that the residual holds."""
    return with_tone_free_noise(fit_jointly(prepared, Hypothesis(model), pool), pool)


def candidates_for(base: JointFit) -> list[Candidate]:
    """Torque and receiver candidates of such shots; the search itself finds additive ones."""
    model, record = base.hypothesis.model, base.prepared[0].shot.record
    if record.quantity == "angle":
        fastest = max(2.0 * s.dynamics.w * math.sin(0.5 * abs(s.dynamics.amplitude)) for s in base.states)
        longest_s = max(float(s.time_s[-1]) for s in base.prepared)
        largest = max(abs(s.dynamics.amplitude) for s in base.states)
        motion = pendulum_candidates(model, fastest, longest_s, largest)
        return [*motion, *reading_candidates(largest), *zero_drifts(longest_s), *kicks(base)]
    small = all(abs(s.dynamics.amplitude) < THRESHOLDS.effects.hertz_law_rad for s in base.states)
    found = [*torque_candidates(model, jewel_law=small), drift_candidate(), *stribeck_candidates(model)]
    # A weak drift too: without it others imitate one that comes to rest.
    longest_s = max(float(s.time_s[-1]) for s in base.prepared)
    found += [settling_candidate(longest_s), settling_candidate(longest_s, THRESHOLDS.effects.fast_settling)]
    f_nat_hz = float(np.mean([s.dynamics.w for s in base.states])) / (2.0 * math.pi)
    return [*found, *receiver_candidates(record.channels, record.quantity, f_nat_hz)]
