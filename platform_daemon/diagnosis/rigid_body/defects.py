"""The manufacturing error that explains a motion which leaves its plane: fits of the rigid rotor, and their proof."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.regression.parameters import Mean
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.noise.model import level_sd as noise_level_sd
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.rigid_rotor.rotor import LostRotorError, NoRestError
from platform_daemon.estimation.physics.rotation import rodrigues_from_rotation
from platform_daemon.estimation.rotor_fit.fit import (
    RotorFit,
    RotorFitError,
    fit_rotor,
    longest_s,
    made_whole,
    samples_per_value_of,
)
from platform_daemon.estimation.rotor_fit.parameters import DEFECTS
from platform_daemon.estimation.rotor_fit.shot import RotorShot

from .each_shot import each_alone
from .exchange import as_far_from
from .found_error import Alike, ManufacturingError, effect_of
from .held_out import HeldOutRotor, held_out_ends
from .rotor_shots import rotor_shots
from .search import defect_of, ranked, rise, total_chi2

_LIMITS = THRESHOLDS.rigid_body


def manufacturing_error(base: JointFit, pool: Executor, *, leaving_noise: bool = False) -> ManufacturingError | None:
    """The error that explains shots which leave their plane; None if none does, or if their drive is not known.

    One whose size may be 0, or is less than anybody can make, is no error: a main axis that leans, or a swing that
    feeds the side modes, is explained by a rotor without one (`sure`).

    The first shot is fitted alone in windows that grow, with each error beside the others; the other shots begin with
    what it found in common, so that their ends are predicted from their beginnings; then all are fitted together, with
    the error that explains the first one best and with those that it could not tell from that.  The least chi^2 has the
    name; where others are as near to it as noise alone would set them apart, the first in `DEFECTS`, the simplest.

    leaving_noise: only an error that leaves no more than noise is of use, so that the search ends where a window of the
    first shot shows much more.
    """
    shots = rotor_shots(base)
    if not shots:
        return None
    most_chi2_per_dof = _LIMITS.given_up_chi2_per_dof if leaving_noise else _LIMITS.explained_chi2_per_dof
    try:
        fitted = _fitted(base, shots, most_chi2_per_dof, pool)
    except (RotorFitError, LostRotorError, NoRestError):
        return None
    return _judged(base, fitted, pool)


@dataclass(frozen=True, kw_only=True)
class _Fitted:
    """alone: fits of each shot alone, with what the first one has in common; alike: of all shots together, with each
    error that they cannot exclude; best: the one of these that is named; excess_sigma, samples: see `_excess`."""

    alone: Sequence[RotorFit]
    alike: Sequence[RotorFit]
    best: RotorFit
    excess_sigma: float
    samples: float
    held_out: HeldOutRotor


def _fitted(base: JointFit, shots: Sequence[RotorShot], most_chi2_per_dof: float, pool: Executor) -> _Fitted:
    """Raises RotorFitError, LostRotorError, NoRestError."""
    best_first, *rivals = ranked(shots[0], pool, most_chi2_per_dof)
    of_first, alone = like_the_first([made_whole(best_first, pool), *rivals], shots, pool)
    together = [_together(alone, pool)]
    if len(shots) > 1:
        # One after the other: shots together keep all cores busy, and two Jacobians would be kept at once.
        for rival in of_first[1:]:
            with suppress(RotorFitError):
                together.append(_together_instead(together[0], of_first[0], rival, pool))
    else:
        together = of_first
    while True:
        excess_sigma, samples = _excess(base, min(together, key=total_chi2))
        alike = _as_good(together, samples)
        best = _named(alike, samples)
        if best.whole:
            break
        together = [made_whole(f, pool) if f is best else f for f in together]
    return _Fitted(
        alone=alone,
        alike=alike,
        best=best,
        excess_sigma=excess_sigma,
        samples=samples,
        held_out=held_out_ends(alone, pool),
    )


def _judged(base: JointFit, fitted: _Fitted, pool: Executor) -> ManufacturingError | None:
    """None: the rotor leaves too much."""
    best, samples, held_out = fitted.best, fitted.samples, fitted.held_out
    noise_chi2_per_dof = THRESHOLDS.regression.noise_chi2_per_dof
    # The right rotor predicts to noise; one that does not lies in a valley beside it.  Where a shot alone leaves more
    # with what the first one has in common, the prediction is not that of the rotor of all.
    predicts = held_out.is_good or not all(f.chi2_per_dof < noise_chi2_per_dof for f in fitted.alone)
    strength, std = best.strength[0], math.sqrt(samples) * best.strength[1]
    least = _LIMITS.least_m if defect_of(best) == "lateral_displacement_m" else _LIMITS.least_rad
    sure = abs(strength) > least and (abs(strength) > _LIMITS.sure_sigma * std or none_leaves_more(best, samples, pool))
    # A rotor without an error stands in the way of effects of one angle only where it leaves surely no more than noise.
    quiet = best.chi2_per_dof < noise_chi2_per_dof and fitted.excess_sigma < _LIMITS.doubtful_sigma
    if not ((quiet and (sure or predicts)) or (sure and best.chi2_per_dof < _LIMITS.explained_chi2_per_dof)):
        return None
    alike = fitted.alike
    wider = max(samples, 1.0 if predicts else min(held_out.chi2_per_dof, _LIMITS.most_wider_chi2))
    if wider > 1.0:
        place = next(k for k, f in enumerate(alike) if f is best)
        alike = [_with_model_error(f, wider) for f in alike]
        best = alike[place]
        std = best.strength[1]
    others = [f for f in alike if f is not best]
    # The same error with the other sign or law of creep, if the shots do not tell it, is not another effect: the error
    # spans both.
    span = max((abs(f.strength[0] - strength) for f in others if f.defect == best.defect), default=0.0)
    return ManufacturingError(
        effect=effect_of(defect_of(best), best.shots[0].geometry.bearing),
        strength=strength,
        std=math.hypot(std, span),
        alike=tuple(sorted((_like_it(f, best) for f in _one_law(others, best)), key=lambda a: a.rise)),
        fit=best,
        held_out=held_out,
        before_chi2=base.chi2,
        parameters=_means(best, others),
        excess_sigma=fitted.excess_sigma,
        sure=sure,
        predicts=predicts,
    )


def none_leaves_more(best: RotorFit, samples: float, pool: Executor) -> bool:
    """A rotor without the error leaves surely more.

    A weak error acts mostly by its square, so that its two signs are hardly told apart and its standard deviation,
    which is that of one sign, says little of 0: a jewel tilted by 0.0097(21) rad was 38 of chi^2 from none (defect
    study, jewel_tilt of -1.061 deg).
    """
    strength, std = best.strength
    if abs(strength) < _LIMITS.weighed_sigma * std:
        return False
    without: dict[str, float] = {defect_of(best): 0.0}
    begun = [replace(shot, values=v.with_numbers(without)) for shot, v in zip(best.shots, best.values, strict=True)]
    found = list[RotorFit]()
    # From the values beside a tiny error the minimum is a step away, from those of a larger one through short windows.
    for first_s in (math.inf, 2.0 * _LIMITS.sign_window_s):
        with suppress(RotorFitError, LostRotorError, NoRestError):
            found.append(fit_rotor(begun, None, pool, first_window_s=first_s, whole=False, known=best.known))
            if rise(found[-1], best) < _LIMITS.sure_sigma**2 * samples:
                return False
    return bool(found)


def like_the_first(
    of_first: Sequence[RotorFit], shots: Sequence[RotorShot], pool: Executor
) -> tuple[list[RotorFit], list[RotorFit]]:
    """The fits of the first shot in another order, and fits of each shot alone that go with the first of these.

    An error that the first shot does not tell from others, as a weak one may not, need not explain the other shots.
    The fit of the first error that does is put first; which of them leaves least, all shots together tell.

    of_first: the best first.

    Raises RotorFitError, LostRotorError, NoRestError.
    """
    if len(shots) == 1:
        return list(of_first), [of_first[0]]
    for k, first in enumerate(of_first):
        with suppress(RotorFitError, LostRotorError, NoRestError):
            begun = made_whole(first, pool)
            fits = each_alone(shots, begun, pool, most_chi2_per_dof=_LIMITS.explained_chi2_per_dof)
            return [begun, *of_first[:k], *of_first[k + 1 :]], fits
    # The values in common may be slightly off for all errors; all shots together may find the right ones.
    return list(of_first), each_alone(shots, of_first[0], pool)


def _one_law(others: Sequence[RotorFit], best: RotorFit) -> list[RotorFit]:
    """Of each error and sign other than the named one, the law of creep that leaves least."""
    found = {(best.defect, best.strength[0] > 0.0): best}
    for fit in sorted(others, key=total_chi2):
        found.setdefault((fit.defect, fit.strength[0] > 0.0), fit)
    return [fit for fit in found.values() if fit is not best]


def _excess(base: JointFit, fit: RotorFit) -> tuple[float, float]:
    """By how many standard deviations a fit leaves more than noise, and then samples per independent value of that."""
    level_sd = max(noise_level_sd(prepared.shot.noise) for prepared in base.prepared)
    sigma = (fit.chi2_per_dof - 1.0) / math.hypot(math.sqrt(2.0 / sum(fit.dof)), level_sd)
    return sigma, samples_per_value_of(fit) if sigma > _LIMITS.doubtful_sigma else 1.0


def _with_model_error(fit: RotorFit, samples: float) -> RotorFit:
    """The fit with the errors of a residual that is no noise, of which so many samples are one independent value, or
    with those of a prediction with so much chi2/dof."""
    wider = math.sqrt(samples)
    return replace(
        fit,
        std=tuple({name: wider * std for name, std in one.items()} for one in fit.std),
        covariance=samples * fit.covariance,
    )


def _like_it(fit: RotorFit, best: RotorFit) -> Alike:
    strength, std = fit.strength
    effect = effect_of(defect_of(fit), fit.shots[0].geometry.bearing)
    return Alike(effect=effect, strength=strength, std=std, rise=rise(fit, best), fit=fit)


def _named(alike: Sequence[RotorFit], samples: float = 1.0) -> RotorFit:
    """The simplest of those whose chi^2 differs from the least by no more than noise makes it differ.

    samples: of the residual per independent value.
    """
    least = min(alike, key=total_chi2)
    equal = [f for f in alike if rise(f, least) < _LIMITS.equal_chi2 * samples]
    return min(equal, key=lambda f: (DEFECTS.index(defect_of(f)), total_chi2(f)))


def _as_good(fits: Sequence[RotorFit], samples: float) -> list[RotorFit]:
    """Those whose chi^2 the data cannot tell from the least."""
    least = min(fits, key=total_chi2)
    return [f for f in fits if rise(f, least) < THRESHOLDS.selection.told_apart_chi2 * samples]


def _together(fits: Sequence[RotorFit], pool: Executor) -> RotorFit:
    """All shots over their whole windows.  Raises RotorFitError."""
    if len(fits) == 1:
        return fits[0]
    start = [replace(f.shots[0], values=f.values[0]) for f in fits]
    return fit_rotor(start, fits[0].defect, pool, first_window_s=longest_s(start))


def _together_instead(joint: RotorFit, first: RotorFit, rival: RotorFit, pool: Executor) -> RotorFit:
    """All shots with another error, which begin as far from the joint fit as the first shot's two fits are apart.

    Raises RotorFitError.
    """
    scale = joint.strength[0] / first.strength[0]
    begun = []
    for shot, v in zip(joint.shots, joint.values, strict=True):
        values = as_far_from(v, first, rival, shot=shot, scale=scale)
        begun.append(replace(shot, values=values.with_numbers(v.start)))
    return fit_rotor(begun, rival.defect, pool, first_window_s=_LIMITS.exchange_window_s, whole=False, predicts=False)


def _means(fit: RotorFit, others: Sequence[RotorFit]) -> dict[str, Mean]:
    """Means over the shots of what is also a parameter of one angle, and the orientation.

    The errors of the shots stem mostly from the common values, so that they do not average out.  They span what the
    other defects that are as good make of each parameter.
    """
    jewel = fit.shots[0].geometry.bearing == "jewel"
    names = ["f_nat_hz", "m_r_am2", "lambda_per_s", *(["tf_over_i_rad_per_s2"] if jewel else [])]
    found = {}
    for name in names:
        values = np.array([getattr(v, name) for v in fit.values])
        errors = np.array([s[name] for s in fit.std])
        common = name == "lambda_per_s"
        off = [np.mean([getattr(v, name) for v in other.values]) - values.mean() for other in others]
        std = math.hypot(float(errors.mean()), max(map(abs, off), default=0.0))
        scatter = None if common or values.size == 1 else float(values.std(ddof=1))
        found[name] = Mean(value=float(values.mean()), std=std, scatter=scatter)
    turned = _turned(fit)
    spread: Array = np.array([[s[f"turn_{a}_rad"] for a in "uvw"] for s in fit.std])
    std = float(np.sqrt(np.mean(spread**2)))
    for k, name in enumerate(("rodrigues_x", "rodrigues_y", "rodrigues_z")):
        scatter = None if len(turned) == 1 else float(turned[:, k].std(ddof=1))
        value = float(turned[:, k].mean())
        off = [abs(float(_turned(other)[:, k].mean()) - value) for other in others]
        found[name] = Mean(value=value, std=math.hypot(std, max(off, default=0.0)), scatter=scatter)
    return found


def _turned(fit: RotorFit) -> Array:
    """Rodrigues vector of each shot, (shots, 3)."""
    return np.array([rodrigues_from_rotation(s.rotor(v).rotation) for s, v in zip(fit.shots, fit.values, strict=True)])
