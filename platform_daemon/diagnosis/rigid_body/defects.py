"""The manufacturing error that explains a motion which leaves its plane: fits of the rigid rotor, and their proof."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.diagnosis.effects.effect import Effect
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
    covariance_of,
    fit_rotor,
    longest_s,
    made_whole,
    samples_per_value_of,
)
from platform_daemon.estimation.rotor_fit.parameters import (
    DEFECTS,
    HELD_WITH_A_DEFECT,
    KNOWN_WITH_A_DEFECT,
    OFF_DRAWING,
    Defect,
)
from platform_daemon.estimation.rotor_fit.shot import RotorShot

from .each_shot import each_alone
from .exchange import as_far_from
from .held_out import HeldOutRotor, held_out_ends
from .rotor_shots import rotor_shots
from .search import defect_of, ranked, rise, total_chi2

_LIMITS = THRESHOLDS.rigid_body
_ROTOR_SOURCE = "manufacturing (paper, sec. ssec:types_of_manufacturing_errors)"


def _effect(name: str, unit: str, what: str) -> Effect:
    return Effect(
        id=name,
        unit=unit,
        sign=0,
        separates=(),
        signature="the motion leaves its plane: a part along the main axis at f and 2f, with side modes",
        source=f"{what}; {_ROTOR_SOURCE}",
    )


STATOR_TILT = _effect("stator_tilt", "rad", "the stator's moment is tilted about v")
ROTOR_TILT = _effect("rotor_tilt", "rad", "the rotor's moment is tilted about v against the thread")
JEWEL_TILT = _effect("jewel_tilt", "rad", "the jewel is tilted about v")
LATERAL_DISPLACEMENT = _effect("lateral_displacement", "m", "the stator is displaced along u")


def effect_of(defect: Defect, bearing: str) -> Effect:
    """The effect of a parameter of the rotor."""
    if defect == "stator_tilt_rad":
        return STATOR_TILT
    if defect == "lateral_displacement_m":
        return LATERAL_DISPLACEMENT
    return JEWEL_TILT if bearing == "jewel" else ROTOR_TILT


@dataclass(frozen=True, kw_only=True)
class Alike:
    """Another error that explains the shots as well: its size, in the effect's unit, by how much chi^2 is above that of
    the named one, and its fit."""

    effect: Effect
    strength: float
    std: float
    rise: float
    fit: RotorFit

    @property
    def in_words(self) -> str:
        """As for the named one."""
        return _in_words(self.effect, self.strength, self.std)


@dataclass(frozen=True, kw_only=True)
class ManufacturingError:
    """What a rotor of five degrees of freedom makes of the shots.

    effect: the named one; strength, std: in its unit; alike: those that explain the shots as well; fit: of all shots;
    held_out: the end of each shot, predicted from its beginning; before_chi2: chi^2 of one angle; parameters: means;
    excess_sigma: by how many standard deviations chi^2 exceeds that of noise, that of the noise's level included.
    sure: the size is surely not 0, and large enough to be an error; else a rotor without one explains the shots.
    predicts: the ends of shots are predicted about as well as noise allows.
    """

    effect: Effect
    strength: float
    std: float
    alike: tuple[Alike, ...]
    fit: RotorFit
    held_out: HeldOutRotor
    before_chi2: float
    parameters: Mapping[str, Mean]
    excess_sigma: float = 0.0
    sure: bool = True
    predicts: bool = True

    @property
    def held(self) -> dict[str, float]:
        """What later fits hold beside the error, or begin with, by name, SI."""
        values = {name: getattr(self.fit.values[0], name) for name in KNOWN_WITH_A_DEFECT}
        return {name: value for name, value in values.items() if value or name not in OFF_DRAWING}

    @property
    def covariance(self) -> tuple[tuple[str, ...], Array]:
        """Of the error and of what is held beside it, as far as it was estimated: names of the rows, (names, names)."""
        places = self.fit.places[0]
        names = tuple(name for name in (defect_of(self.fit), *HELD_WITH_A_DEFECT) if name in places)
        return names, covariance_of(self.fit, names)

    @property
    def in_words(self) -> str:
        """stator tilted by 2.030(12) deg about v."""
        return _in_words(self.effect, self.strength, self.std)


def _in_words(effect: Effect, strength: float, std: float) -> str:
    if effect is LATERAL_DISPLACEMENT:
        return f"stator displaced by {_with_error(1e3 * strength, 1e3 * std)} mm along u"
    size = _with_error(math.degrees(strength), math.degrees(std))
    return f"{effect.id.removesuffix('_tilt')} tilted by {size} deg about v"


def _with_error(value: float, std: float) -> str:
    """2.030(12): two digits of the standard deviation."""
    digits = max(0, 1 - math.floor(math.log10(std)))
    return f"{value:.{digits}f}({round(std * 10.0**digits)})"


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
    noise_chi2_per_dof = THRESHOLDS.regression.noise_chi2_per_dof
    most_chi2_per_dof = _LIMITS.given_up_chi2_per_dof if leaving_noise else _LIMITS.explained_chi2_per_dof
    try:
        best_first, *rivals = ranked(shots[0], pool, most_chi2_per_dof)
        of_first, fits = like_the_first([made_whole(best_first, pool), *rivals], shots, pool)
        together = [_together(fits, pool)]
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
        held_out = held_out_ends(fits, pool)
    except (RotorFitError, LostRotorError, NoRestError):
        return None
    # The right rotor predicts to noise; one that does not lies in a valley beside it.  Where a shot alone leaves more
    # with what the first one has in common, the prediction is not that of the rotor of all.
    alone = all(f.chi2_per_dof < noise_chi2_per_dof for f in fits)
    predicts = held_out.is_good or not alone
    strength, std = best.strength[0], math.sqrt(samples) * best.strength[1]
    least = _LIMITS.least_m if defect_of(best) == "lateral_displacement_m" else _LIMITS.least_rad
    sure = abs(strength) > least and (abs(strength) > _LIMITS.sure_sigma * std or none_leaves_more(best, samples, pool))
    # A rotor without an error stands in the way of effects of one angle only where it leaves surely no more than noise.
    noise = best.chi2_per_dof < noise_chi2_per_dof and excess_sigma < _LIMITS.doubtful_sigma and (sure or predicts)
    if not (noise or (sure and best.chi2_per_dof < _LIMITS.explained_chi2_per_dof)):
        return None
    wider = max(samples, 1.0 if predicts else min(held_out.chi2_per_dof, _LIMITS.most_wider_chi2))
    if wider > 1.0:
        place = next(k for k, f in enumerate(alike) if f is best)
        alike = [_with_model_error(f, wider) for f in alike]
        best = alike[place]
        std = best.strength[1]
    bearing = shots[0].geometry.bearing
    others = [f for f in alike if f is not best]
    # The same error with the other sign or law of creep, if the shots do not tell it, is not another effect: the error
    # spans both.
    span = max((abs(f.strength[0] - strength) for f in others if f.defect == best.defect), default=0.0)
    return ManufacturingError(
        effect=effect_of(defect_of(best), bearing),
        strength=strength,
        std=math.hypot(std, span),
        alike=tuple(sorted((_like_it(f, best) for f in _one_law(others, best)), key=lambda a: a.rise)),
        fit=best,
        held_out=held_out,
        before_chi2=base.chi2,
        parameters=_means(best, others),
        excess_sigma=excess_sigma,
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
