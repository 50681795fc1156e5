"""A manufacturing error that a rotor of five degrees of freedom shows: which one, how large, and what acts like it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from platform_daemon.diagnosis.effects.effect import Effect
from platform_daemon.diagnosis.regression.parameters import Mean
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.rotor_fit.fit import RotorFit, covariance_of
from platform_daemon.estimation.rotor_fit.parameters import (
    HELD_WITH_A_DEFECT,
    KNOWN_WITH_A_DEFECT,
    OFF_DRAWING,
    Defect,
)

from .held_out import HeldOutRotor
from .search import defect_of

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
