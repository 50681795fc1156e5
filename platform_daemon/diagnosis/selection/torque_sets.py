"""Torques first: every torque and every pair of torques fitted, under sign rules, the best kept if it is worth it.

Where the noise is small, linear scores mislead: two losses together may explain what either alone makes worse. A
fit of a set takes tenths of a second on an angle, so all of them are tried.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

from platform_daemon.diagnosis.effects.additive import OSCILLATIONS
from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.effects.kick import KICK
from platform_daemon.diagnosis.regression.cross_validation import CrossValidation, cross_validate
from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.shots.thread_pool import InlineExecutor
from platform_daemon.diagnosis.thresholds import THRESHOLDS

from .amplitude_laws import is_timed, laws_of_amplitude, time_is_doubtful, timed_torques
from .further_kicks import with_further_kicks
from .kick_search import kick_missing, kicks
from .refits import allowed_refit, refined
from .scales import at_best_scales
from .sign_constraints import negative_effects, signs_allowed
from .significance import LEVEL, log_chance

_LIMITS = THRESHOLDS.selection


@dataclass(frozen=True)
class TorqueSet:
    """A set that fits without forbidden signs, and how well it predicts."""

    fitted: JointFit
    held_out: CrossValidation

    @property
    def error(self) -> float:
        """nRMSE of the prediction."""
        return self.held_out.total.nrmse


@dataclass(frozen=True, kw_only=True)
class TorqueSearch:
    """What the search of sets found.

    Attributes:
        best: the declared model with the torques that explain most and predict best; itself if none is worth it.
        rejected: the set that explains far more than that, if one does, but does not predict what was not used.
        others: where the best leaves more than noise, the sets that leave hardly more than it does; the best first.
        next_larger: the set with one torque more that leaves least, whether that is sure or not; None: none was tried.
    """

    best: JointFit
    rejected: JointFit | None
    others: tuple[JointFit, ...]
    next_larger: JointFit | None


def best_torques(
    base: JointFit,
    candidates: Sequence[Candidate],
    trials: float,
    pool: Executor,
    progress: Callable[[str, float], None],
) -> TorqueSearch:
    """Of the declared model with every set of these torques."""
    best = TorqueSet(base, cross_validate(base, pool))
    known: dict[frozenset[object], JointFit] = {frozenset(): base}
    leaders: list[JointFit] = [base]
    rejected: JointFit | None = None
    for size in range(1, _LIMITS.largest_set + 1):
        progress(f"refits of sets of {size} torques", 0.25 + 0.15 * size)
        if size > 2 and _complete(best.fitted):
            break
        grown = leaders if size > 2 else sorted(known.values(), key=lambda f: f.chi2)
        allowed = _allowed(_sets(grown, [*candidates, *_kicked(best.fitted)], known, size), pool)
        # A best set of a size before that was tried with its kicks then.
        grows = _keys(best.fitted) and len(_keys(best.fitted)) == size - 1
        allowed = with_further_kicks(allowed, best.fitted if grows else None, pool)
        known |= {_keys(f): f for f in reversed(allowed)}
        best = _better(best, allowed, trials, pool)
        rejected = min([f for f in (rejected, *allowed[:1]) if f is not None], key=lambda f: f.chi2, default=None)
        leaders = [f for f in allowed if f.chi2 < allowed[0].chi2 * (1.0 + _LIMITS.rival_share)][: _LIMITS.grown_sets]
    larger = [f for f in known.values() if len(_keys(f)) == len(_keys(best.fitted)) + 1]
    far_better = rejected is not None and rejected.chi2 < _LIMITS.rejected_share * best.fitted.chi2
    return TorqueSearch(
        best=best.fitted,
        rejected=rejected if far_better else None,
        others=() if best.fitted.leaves_noise else alternatives(best.fitted, list(known.values())),
        next_larger=min(larger, key=lambda f: f.chi2, default=None),
    )


def alternatives(best: JointFit, fits: Sequence[JointFit]) -> tuple[JointFit, ...]:
    """Other sets of as few effects, whose misfit is at most so many times that of a model which leaves no noise.

    Their chi^2 does not exclude them: what is left is the model's error, of which nobody knows the distribution. Sets
    that hold a smaller one of this kind are not told. Beside a torque that depends on time a law of the amplitude is
    told in any case, unless shots part the two.
    """
    limit = _LIMITS.alternative_misfit**2 * best.chi2
    near = [f for f in fits if _keys(f) and f.chi2 < limit and len(_keys(f)) <= len(_keys(best))]
    least = [f for f in near if not any(_keys(o) < _keys(f) for o in near) and not _keys(f) <= _keys(best)]
    if timed_torques(best) and time_is_doubtful(best) and not any(map(laws_of_amplitude, least)):
        laws = [f for f in fits if laws_of_amplitude(f) and len(_keys(f)) <= len(_keys(best))]
        least += sorted(laws, key=lambda f: f.chi2)[:1]
    return tuple(sorted(least, key=lambda f: f.chi2))


def _kicked(at: JointFit) -> list[Candidate]:
    """Kicks that explain the residual of a set; those of the declared model are candidates already."""
    return kicks(at) if _keys(at) else []


def _complete(at: JointFit) -> bool:
    """Nothing but noise is left: a larger set would explain noise."""
    return bool(_keys(at)) and at.leaves_noise


def _keys(at: JointFit) -> frozenset[object]:
    """The effects of a set, whatever their hidden scales; lines and second modes are found beside it."""
    return frozenset(c.effect for c in at.hypothesis.effects if c.effect not in OSCILLATIONS)


def _sets(
    grown: Sequence[JointFit], candidates: Sequence[Candidate], known: dict[frozenset[object], JointFit], size: int
) -> list[tuple[Candidate, JointFit]]:
    """Additions to sets that are one smaller, each new set once, started from its best subset."""
    best: dict[object, tuple[Candidate, JointFit]] = {}
    for at, c in itertools.product(grown, candidates):
        keys = _keys(at) | {c.effect}
        if len(keys) != size or len(_keys(at)) != size - 1 or keys in known:
            continue
        # Torques that depend on time are traced through every half cycle, which takes as long as ten others.
        if size > 1 and is_timed(c) and at not in grown[: _LIMITS.timed_sets]:
            continue
        # Of an effect with several forms each is tried.
        forms = frozenset((c.effect.id, c.detail) for c in (*at.hypothesis.effects, c))
        if forms not in best or at.chi2 < best[forms][1].chi2:
            best[forms] = c, at
    return list(best.values())


def _allowed(sets: Sequence[tuple[Candidate, JointFit]], pool: Executor) -> list[JointFit]:
    """Those that can be fitted without forbidden signs, the best first; those in front with their scales at the best.

    Of a single shot, several are fitted at once.
    """
    alone = bool(sets) and len(sets[0][1].prepared) == 1
    inner, every = (InlineExecutor(), pool.map) if alone else (pool, map)
    found = [f for f in every(lambda s: allowed_refit(s[1].hypothesis.plus(s[0]), s[1], inner), sets) if f is not None]
    fits = sorted((f for f in found if signs_allowed(f)), key=lambda f: f.chi2)
    front = [f for f in fits if f.chi2 < _LIMITS.worth_a_scale * fits[0].chi2][: _LIMITS.sharpened_sets]
    front += [f for f in fits[len(front) :] if _falls_to_a_floor(f)]
    sharp = list(every(lambda f: refined(at_best_scales(f, inner), inner), front))
    others = [f for f in fits if not any(f is one for one in front)]
    possible = (f for f in (*sharp, *others) if signs_allowed(f) and not kick_missing(f))
    return sorted(possible, key=lambda f: f.chi2)


def _falls_to_a_floor(at: JointFit) -> bool:
    """Friction that falls with the speed to a floor, as Stribeck's does: two torques of one law.

    At the speed scale that is best without a floor, a floor explains next to nothing.
    """
    return {"stribeck_friction", "coulomb_friction"} <= {c.effect.id for c in at.hypothesis.effects}


def _better(best: TorqueSet, allowed: Sequence[JointFit], trials: float, pool: Executor) -> TorqueSet:
    """The set of a size that predicts best among those that fit about best, if it is worth its parameters."""
    rivals = [f for f in allowed if f.chi2 < allowed[0].chi2 * (1.0 + _LIMITS.rival_share)][: _LIMITS.compared_sets]
    rivals += [f for f in _laws_of_amplitude(allowed) if not any(f is r for r in rivals)]
    scored = [TorqueSet(f, cross_validate(f, pool)) for f in rivals]
    least = min((s.error for s in scored), default=0.0)
    for one in sorted((s for s in scored if not _imitates_a_law(s.fitted, rivals)), key=lambda s: _rank(s, least)):
        if _sure(best.fitted, one.fitted, trials) and _predicts(best, one):
            return one
    return best


def _imitates_a_law(at: JointFit, rivals: Sequence[JointFit]) -> bool:
    """A set with a kick or with a loss that feeds the motion, beside which a plain one leaves as little.

    Either mends what a law is wrong by.  A kick that is too small to be seen at its instant has no other proof than
    that nothing else explains as much.
    """
    most = at.chi2 + _LIMITS.kick_chi2 * at.noise_factor
    return _mends(at) and any(f.chi2 < most for f in rivals if not _mends(f))


def _mends(at: JointFit) -> bool:
    return KICK in _keys(at) or bool(negative_effects(at))


def _laws_of_amplitude(allowed: Sequence[JointFit]) -> list[JointFit]:
    """The best set of a size that knows no time, where the best one does, leaves no noise and is hardly better.

    In one swing that dies, a time constant of its own follows any law of the amplitude, with one parameter more.
    """
    if not allowed or not time_is_doubtful(allowed[0]) or not timed_torques(allowed[0]):
        return []
    limit = _LIMITS.alternative_misfit**2 * allowed[0].chi2
    return [f for f in allowed if not timed_torques(f) and f.chi2 < limit][:1]


def _rank(one: TorqueSet, least: float) -> tuple[bool, bool, int, int, float]:
    """Of sets that predict as well: laws of the amplitude, friction that takes energy, then few parameters."""
    fitted, feeding = one.fitted, len(negative_effects(one.fitted))
    doubtful = time_is_doubtful(fitted)
    timed = doubtful and timed_torques(fitted)
    ratio = _LIMITS.alternative_misfit if doubtful and not timed else _LIMITS.as_good_ratio
    return one.error > ratio * least, timed, feeding, _parameters(fitted), one.error


def _sure(smaller: JointFit, larger: JointFit, trials: float) -> bool:
    """The fall of chi^2 is no chance."""
    fall = (smaller.chi2 - larger.chi2) / larger.noise_factor
    added = _parameters(larger) - _parameters(smaller)
    count = len(_keys(larger))
    return log_chance(fall, max(1, added), trials**count / math.factorial(count)) < LEVEL


def _parameters(at: JointFit) -> int:
    return sum(1 + bool(c.hidden) for c in at.hypothesis.effects)


def _predicts(smaller: TorqueSet, larger: TorqueSet) -> bool:
    """Better on held-out data; where nothing but noise is left, no worse is enough, for noise is all that is scored."""
    if larger.fitted.leaves_noise:
        return larger.held_out.worse_by(smaller.held_out) < 0.0
    patched = _keys(smaller.fitted) and _patches(larger.fitted, smaller.fitted)
    return larger.error < smaller.error * (1.0 / _LIMITS.alternative_misfit if patched else _LIMITS.helping_ratio)


def _patches(larger: JointFit, smaller: JointFit) -> bool:
    """The larger set has what may mend what laws of the motion miss: a kick, a curved scale, a torque of time."""
    new_time = timed_torques(larger) and not timed_torques(smaller)
    scales = [sum(c.change is not None for c in at.hypothesis.receivers) for at in (larger, smaller)]
    curved = scales[0] > scales[1]
    return (new_time and time_is_doubtful(larger)) or curved or KICK in _keys(larger) - _keys(smaller)
