"""What the diagnosis knows of an effect: its id, its sign rule, how it shows, what would separate it, and who found it.

An effect offers candidates for a set of shots: the effect at one place (axis, frequency, decay time ...), with columns,
the change of a shot's channels per unit of strength. Torque effects take their columns from their term in
estimation/terms; signal effects write them down, and say how to undo them in the data.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from platform_daemon.estimation.arrays import Array
from platform_daemon.estimation.terms import TorqueTerm

from ..look import Look
from ..shots import Shot

Columns = Callable[[Look], Array]
Undo = Callable[[Array, Shot, Array], Array]


@dataclass(frozen=True)
class Detail:
    """Where an effect acts; None: does not apply."""

    axis: str | None = None
    frequency_hz: float | None = None
    tau_s: float | None = None
    sample: int | None = None
    start: str | None = None
    end: str | None = None


@dataclass(frozen=True)
class Effect:
    """One effect.

    Attributes:
        id: public name.
        unit: of its strength.
        sign: 1: physics allows no negative strength; 0: either sign.
        separates: keys of the measurements (proposals.py) that set it apart from its look-alikes.
        source: who described it.
    """

    id: str
    unit: str
    sign: int
    separates: tuple[str, ...]
    source: str


@dataclass(frozen=True)
class Candidate:
    """An effect at one place.

    Attributes:
        effect, detail: what and where.
        term: the torque term, for torque effects; its first coefficient is the strength, the others are `hidden`.
        hidden: values of the term's further coefficients, in their units.
        columns: (q, channels, m) from a Look, for signal effects.
        undo: samples (channels, n), shot, strengths (q,) -> samples freed from the effect.
        shared: one strength for all shots; else each shot has its own.
        size: number of columns.
    """

    effect: Effect
    detail: Detail = field(default_factory=Detail)
    term: TorqueTerm | None = None
    hidden: tuple[float, ...] = ()
    columns: Columns | None = None
    undo: Undo | None = None
    shared: bool = True
    size: int = 1

    @property
    def key(self) -> tuple[str, Detail]:
        """Identity."""
        return self.effect.id, self.detail
