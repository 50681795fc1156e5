"""What the diagnosis knows of an effect: its id, its sign rule, how it shows, what would separate it, and who found it.

An effect is tried as candidates: the effect at one place (axis, frequency, decay time ...). There are four kinds.

* A torque candidate names a term of estimation/physics/torques; its columns come with the term's derivatives.
* A receiver candidate changes the channels of the model: it has columns, the change per unit of strength, and the
  whole change at any strength.
* A kick begins the swing anew at an instant; its columns are the answer to a small one.
* An additive candidate is a sum with the signal: it has columns of its own, linear in their amplitudes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from platform_daemon.diagnosis.shots.linearisation import Linearisation
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.torque_term import TorqueTerm

Columns = Callable[[Linearisation], Array]
Change = Callable[[Linearisation, float], Array]
Public = Callable[[float, float, float], tuple[float, float]]


def unchanged(strength: float, sd: float, f_nat_hz: float) -> tuple[float, float]:
    """Publish a strength in the unit in which it is fitted."""
    return strength, sd


@dataclass(frozen=True)
class Detail:
    """Where an effect acts; None: does not apply."""

    axis: str | None = None
    frequency_hz: float | None = None
    tau_s: float | None = None
    sample: int | None = None
    start: str | None = None
    end: str | None = None


@dataclass(frozen=True, kw_only=True)
class Effect:
    """One effect.

    Attributes:
        id: public name.
        unit: of its strength.
        sign: 1: physics allows no negative strength; 0: either sign.
        separates: keys of the measurements (next_measurements.py) that separate it from effects that look alike.
        signature: how it shows in the residual.
        source: who described it.
        absorbed: the part of it that declared parameters take up, whatever its size.
    """

    id: str
    unit: str
    sign: int
    separates: tuple[str, ...]
    signature: str
    source: str
    absorbed: str = ""


@dataclass(frozen=True)
class Candidate:
    """An effect at one place.

    Attributes:
        effect, detail: what and where.
        term: the torque term, for torque candidates; its first coefficient is the strength, the others are `hidden`.
        hidden: values of the term's further coefficients, in their units.
        columns: (q, channels, m) from a Linearisation, for receiver (q = 1) and additive candidates.
        change: (linearisation, strength) -> change of the model's channels, (channels, m), for receiver candidates.
        shared: additive only: sizes are common to all shots (tied to the start of the shot), else each has its own.
        of: coefficient of the declared model that the strength is a share of, as every shot has it; "": of none.
        public: (strength of the fit, its sd, mean natural frequency in Hz) -> the same as published.
        parts: the same effect on single channels, whose columns are these columns in order.
        near: (share of a grid step) -> the same effect at neighbouring places or hidden scales, itself among them.
        scale_limits, at_scale: between what the hidden scale is sought by refits, and the same effect at any of them.
        largest: size of the strength beyond which it is no longer a small effect of this kind, but something else.
        tones_hz: of steady tones, all that belong together.
        trials: number of independent places that were searched; the p-value is corrected for it.
        held: further numbers that a fit with this effect holds, by public name, SI.
        kick_at_s: of a kick: its instant, s after the first sample; the strength is a step of the velocity there.
        f_nat_course: (time in s) -> relative change of f_nat by a unit of strength, of torques that are only this.
    """

    effect: Effect
    detail: Detail = field(default_factory=Detail)
    term: TorqueTerm | None = None
    hidden: tuple[float, ...] = ()
    of: str = ""
    columns: Columns | None = None
    change: Change | None = None
    shared: bool = True
    size: int = 1
    public: Public = unchanged
    parts: tuple[Candidate, ...] = ()
    near: Callable[[float], list[Candidate]] | None = None
    scale_limits: tuple[float, float] | None = None
    at_scale: Callable[[float], Candidate] | None = None
    largest: float = math.inf
    tones_hz: tuple[float, ...] = ()
    trials: float = 1.0
    held: Mapping[str, float] = field(default_factory=dict, compare=False)
    kick_at_s: float | None = None
    f_nat_course: Callable[[Array], Array] | None = None

    def allows(self, strength: float) -> bool:
        """True for a strength that physics allows."""
        return strength * self.effect.sign >= 0.0 and abs(strength) <= self.largest

    @property
    def key(self) -> tuple[str, Detail, tuple[float, ...]]:
        """Identity."""
        return self.effect.id, self.detail, self.hidden

    @property
    def additive(self) -> bool:
        """True if the effect is a sum with the signal."""
        return self.term is None and self.change is None and self.kick_at_s is None
