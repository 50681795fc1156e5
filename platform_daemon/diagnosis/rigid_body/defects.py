"""The manufacturing error that explains a motion which leaves its plane: fits of the rigid rotor, and their proof."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.diagnosis.effects.effect import Effect
from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.regression.parameters import Mean
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.observation_model import DipoleObservation
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.rigid_rotor.rotor import LostRotorError, NoRestError, RotorValues
from platform_daemon.estimation.physics.rotation import rodrigues_from_rotation
from platform_daemon.estimation.rotor_fit.fit import RotorFit, RotorFitError, Stage, exchanged, fit_rotor, longest_s
from platform_daemon.estimation.rotor_fit.parameters import DEFECTS, HELD_WITH_A_DEFECT, Defect, free_parameters
from platform_daemon.estimation.rotor_fit.shot import RotorShot
from platform_daemon.estimation.thresholds import THRESHOLDS as FIT_LIMITS

_LIMITS = THRESHOLDS.rigid_body
_TILT: Defect = "stator_tilt_rad"  # the one that is searched; what acts alike is looked for beside it
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
class HeldOutRotor:
    """Of each shot: chi^2 of the part that was predicted, its degrees of freedom, squares of the residual and of the
    data there."""

    chi2: tuple[float, ...]
    dof: tuple[float, ...]
    squares: tuple[float, ...]
    energy: tuple[float, ...]

    @property
    def chi2_per_dof(self) -> float:
        """Of all shots."""
        return sum(self.chi2) / sum(self.dof)

    @property
    def nrmse(self) -> float:
        """Rms of the error over that of the data."""
        return math.sqrt(sum(self.squares) / sum(self.energy))


@dataclass(frozen=True, kw_only=True)
class Alike:
    """Another error that explains the shots as well: its size, in the effect's unit, and by how much chi^2 rises."""

    effect: Effect
    strength: float
    std: float
    rise: float

    @property
    def in_words(self) -> str:
        """As for the named one."""
        return _in_words(self.effect, self.strength, self.std)


@dataclass(frozen=True, kw_only=True)
class ManufacturingError:
    """What a rotor of five degrees of freedom makes of the shots.

    effect: the named one; strength, std: in its unit; alike: those that explain the shots as well; fit: of all shots;
    held_out: the end of each shot, predicted from its beginning; before_chi2: chi^2 of one angle; parameters: means.
    """

    effect: Effect
    strength: float
    std: float
    alike: tuple[Alike, ...]
    fit: RotorFit
    held_out: HeldOutRotor
    before_chi2: float
    parameters: Mapping[str, Mean]

    @property
    def held(self) -> dict[str, float]:
        """What is common to all shots beside the error and lambda, by name, SI: later fits hold it."""
        values = self.fit.values[0]
        return {name: getattr(values, name) for name in HELD_WITH_A_DEFECT}

    @property
    def covariance(self) -> tuple[tuple[str, ...], Array]:
        """Of the error and of what is held beside it, as far as it was estimated: names of the rows, (names, names)."""
        places = self.fit.places[0]
        names = tuple(name for name in (_defect_of(self.fit), *HELD_WITH_A_DEFECT) if name in places)
        rows = [places[name] for name in names]
        return names, self.fit.covariance[np.ix_(rows, rows)]

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


def manufacturing_error(base: JointFit, pool: Executor) -> ManufacturingError | None:
    """The error that explains shots which leave their plane; None if none does, or if their drive is not known.

    The first shot is fitted alone in windows that grow, with each error in turn; the others begin with what it found in
    common, so that their ends are predicted from their beginnings; then all are fitted together, with the error that
    explains it best and with those that it could not tell from that.  Of errors that explain the shots alike the first
    one in `DEFECTS` has the name.
    """
    shots = _rotor_shots(base)
    if not shots:
        return None
    try:
        ranked = _ranked(shots[0], pool)
        fits = _each(shots, ranked[0], pool)
        together = [_together(fits, pool)]
        if len(shots) > 1:
            together += _rivals(together[0], [_defect_of(f) for f in ranked[1:]], pool)
        else:
            together = ranked
        alike = _as_good(together)
        best = min(alike, key=lambda f: DEFECTS.index(_defect_of(f)))
        if best.defect != ranked[0].defect:
            fits = _each(shots, next(f for f in ranked if f.defect == best.defect), pool)
        held_out = _held_out(fits)
    except RotorFitError:
        return None
    strength, std = best.strength
    if not best.chi2_per_dof < _LIMITS.explained_chi2_per_dof or not abs(strength) > _LIMITS.sure_sigma * std:
        return None
    bearing = shots[0].geometry.bearing
    others = [f for f in alike if f is not best]
    return ManufacturingError(
        effect=effect_of(_defect_of(best), bearing),
        strength=strength,
        std=std,
        alike=tuple(_like_it(f, best) for f in others),
        fit=best,
        held_out=held_out,
        before_chi2=base.chi2,
        parameters=_means(best, others),
    )


def _rotor_shots(base: JointFit) -> list[RotorShot]:
    """Shots with start values from one angle; none if a shot's drive or geometry is not known."""
    shots = []
    for prepared, state in zip(base.prepared, base.states, strict=True):
        known, observed, shot = prepared.shot.rotor, state.observation, prepared.shot
        if known is None or not isinstance(observed, DipoleObservation):
            return []
        coefficients = dict(
            zip((c.name for c in base.hypothesis.model.coefficients), state.dynamics.values, strict=True)
        )
        record, jewel = shot.record, known.geometry.bearing == "jewel"
        loss = coefficients.get("lambda_per_s", 0.0)
        f_nat_hz, m_r_am2 = state.dynamics.w / (2.0 * math.pi), abs(observed.m_r)
        values = RotorValues(
            f_nat_hz=f_nat_hz,
            m_r_am2=m_r_am2,
            distance_m=known.geometry.distance_m(f_nat_hz, m_r_am2),
            lambda_per_s=min(loss, _LIMITS.jewel_damping_per_s) if jewel else loss,
            rotation=known.facing(observed.rotation),
            tf_over_i_rad_per_s2=coefficients.get("tf_over_i_rad_per_s2", 0.0),
            friction_coefficient=known.geometry.friction_coefficient,
            side_damping_per_s=_LIMITS.side_damping_per_s,
            creep_m_per_s=_LIMITS.creep_m_per_s if jewel else 0.0,
        )
        late_s = record.valid_from / record.sampling_rate_hz
        shots.append(
            RotorShot(
                samples=record.valid,
                rate_hz=record.sampling_rate_hz,
                sd=shot.noise.sd,
                geometry=known.geometry,
                drive=replace(known.drive, rx_start_s=known.drive.rx_start_s + late_s),
                values=values,
                moving=known.moving,
            )
        )
    return shots


def _alone(shot: RotorShot, pool: Executor) -> RotorFit:
    """One shot from the start, by the sign of the tilt that a short window prefers.  Raises RotorFitError."""
    n = shot.count(_LIMITS.sign_window_s)
    tried = []
    for sign in (1.0, -1.0):
        begun = replace(shot, values=shot.values.with_numbers({_TILT: sign * _LIMITS.start_rad}))
        try:
            tried.append(fit_rotor([replace(begun, samples=shot.samples[:, :n])], _TILT, pool, whole=False))
        except RotorFitError:
            continue
    if not tried:
        raise RotorFitError("a short window finds no rotor")
    best = min(tried, key=lambda f: sum(f.chi2))
    begun = replace(shot, values=best.values[0])
    return fit_rotor([begun], _TILT, pool, first_window_s=2.0 * _LIMITS.sign_window_s)


def _like(shot: RotorShot, other: RotorShot, found: RotorFit, pool: Executor) -> RotorFit:
    """A shot with what another one found in common, held; its own values start as far from one angle's as there."""
    there, v = found.values[0], shot.values
    values = replace(
        there,
        f_nat_hz=v.f_nat_hz + there.f_nat_hz - other.values.f_nat_hz,
        m_r_am2=v.m_r_am2 * there.m_r_am2 / other.values.m_r_am2,
        rotation=v.rotation,
        tf_over_i_rad_per_s2=there.tf_over_i_rad_per_s2,
    )
    if other.values.tf_over_i_rad_per_s2 > 0.0 and v.tf_over_i_rad_per_s2 > 0.0:
        ratio = there.tf_over_i_rad_per_s2 / other.values.tf_over_i_rad_per_s2
        values = replace(values, tf_over_i_rad_per_s2=v.tf_over_i_rad_per_s2 * ratio)
    common = [p.name for p in free_parameters(shot.geometry, [_defect_of(found)], moving=shot.moving) if p.common]
    return fit_rotor([replace(shot, values=values)], found.defect, pool, held=common)


def _ranked(shot: RotorShot, pool: Executor) -> list[RotorFit]:
    """Fits of one shot with each defect that it cannot exclude, the best first.  Raises RotorFitError.

    All of them act alike at first: the stator's tilt is tried in windows that grow from the start, the others in longer
    ones from what it is to first order in their terms.
    """
    first = _alone(shot, pool)
    fits = [first, *_rivals(first, [d for d in DEFECTS if d != _TILT], pool, first_window_s=_LIMITS.rival_window_s)]
    fits.sort(key=_total)
    return [fits[0], *(f for f in fits[1:] if _rise(f, fits[0]) < FIT_LIMITS.rigid_rotor.rival_chi2)]


def _rivals(
    found: RotorFit, rivals: Sequence[Defect], pool: Executor, first_window_s: float = math.inf
) -> list[RotorFit]:
    """The same shots with other defects, as far as there are such rotors."""
    fits = []
    for rival in rivals:
        try:
            values = exchanged(found, rival, pool)
            begun = [replace(s, values=v) for s, v in zip(found.shots, values, strict=True)]
            fits.append(fit_rotor(begun, rival, pool, first_window_s=first_window_s, beside=found))
        except RotorFitError:
            continue
    return fits


def _like_it(fit: RotorFit, best: RotorFit) -> Alike:
    strength, std = fit.strength
    effect = effect_of(_defect_of(fit), fit.shots[0].geometry.bearing)
    return Alike(effect=effect, strength=strength, std=std, rise=_rise(fit, best))


def _total(fit: RotorFit) -> float:
    return sum(fit.chi2)


def _as_good(fits: Sequence[RotorFit]) -> list[RotorFit]:
    """Those whose chi^2 the data cannot tell from the least."""
    least = min(fits, key=_total)
    return [f for f in fits if _rise(f, least) < THRESHOLDS.selection.told_apart_chi2]


def _rise(fit: RotorFit, best: RotorFit) -> float:
    """Of chi^2 over that of the best fit, in units of what that leaves."""
    return (_total(fit) - _total(best)) / max(1.0, best.chi2_per_dof)


def _defect_of(fit: RotorFit) -> Defect:
    assert fit.defect is not None
    return fit.defect


def _each(shots: Sequence[RotorShot], first: RotorFit, pool: Executor) -> list[RotorFit]:
    """Fits of each shot alone, that of the first one given.  Raises RotorFitError."""
    return [first, *(_like(shot, shots[0], first, pool) for shot in shots[1:])]


def _together(fits: Sequence[RotorFit], pool: Executor) -> RotorFit:
    """All shots over their whole windows.  Raises RotorFitError."""
    if len(fits) == 1:
        return fits[0]
    start = [replace(f.shots[0], values=f.values[0]) for f in fits]
    return fit_rotor(start, fits[0].defect, pool, first_window_s=longest_s(start))


def _held_out(fits: Sequence[RotorFit]) -> HeldOutRotor:
    """The end of each shot, predicted from its beginning: at most 70 % of the first shot, 30 % of the others, whose
    common values are those of the first."""
    rows = []
    for k, fit in enumerate(fits):
        shot = fit.shots[0]
        share = THRESHOLDS.regression.own_share if k else THRESHOLDS.regression.split_share
        whole = shot.samples.shape[1] / shot.rate_hz
        own = Stage(fit.window_s, fit.values, _total(fit))
        early = [s for s in fit.stages if s.window_s <= share * whole]
        stage = (early or list(fit.stages) or [own])[-1]
        window_s, values = stage.window_s, stage.values[0]
        n = shot.count(window_s)
        try:
            model, _ = shot.rotor(values).dm_dt(shot.samples.shape[1], shot.rate_hz)
        except (NoRestError, LostRotorError):
            model = np.zeros_like(shot.samples)
        left, data = (shot.samples - model)[:, n:], shot.samples[:, n:]
        left = left - left.mean(axis=1, keepdims=True)
        rows.append(
            (
                float(np.sum((left / shot.sd[:, None]) ** 2)),
                float(left.size),
                float(np.sum(left**2)),
                float(np.sum(data**2)),
            )
        )
    chi2, dof, squares, energy = zip(*rows, strict=True)
    return HeldOutRotor(chi2=chi2, dof=dof, squares=squares, energy=energy)


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
    turned = np.array(
        [rodrigues_from_rotation(s.rotor(v).rotation) for s, v in zip(fit.shots, fit.values, strict=True)]
    )
    spread: Array = np.array([[s[f"turn_{a}_rad"] for a in "uvw"] for s in fit.std])
    std = float(np.sqrt(np.mean(spread**2)))
    for k, name in enumerate(("rodrigues_x", "rodrigues_y", "rodrigues_z")):
        scatter = None if len(turned) == 1 else float(turned[:, k].std(ddof=1))
        found[name] = Mean(value=float(turned[:, k].mean()), std=std, scatter=scatter)
    return found
