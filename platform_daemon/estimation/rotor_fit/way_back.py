"""The way back to the floor of a curved valley after a step of a rotor's fit."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.rigid_rotor.rotor import RotorValues
from platform_daemon.estimation.thresholds import THRESHOLDS

from .layout import Layout

LIMITS = THRESHOLDS.rigid_rotor


class RotorFitError(ValueError):
    """The fit finds no rotor; the text says why."""


@dataclass(frozen=True, eq=False)
class Point:
    """Values of each shot, their residuals, and chi^2 with what is known beforehand."""

    values: list[RotorValues]
    left: list[Array]
    total: float


@dataclass(eq=False)
class WayBack:
    """The way back to the floor after a step.

    layout: of the parameters; begun: total chi^2 before the step, by the time steps of the Jacobian; to_beat: the same
    by those of trials; strong, weight: as `strong_directions` has them; next_values: where it goes on; best: the least
    place so far.
    """

    layout: Layout
    begun: float
    to_beat: float
    strong: Array
    weight: Array
    next_values: list[RotorValues]
    best: Point | None = None
    ended: bool = False
    backs: list[Array] = field(default_factory=list)
    went: list[Array] = field(default_factory=list)

    @property
    def total(self) -> float:
        """Least chi^2 so far; infinite before there is one."""
        return math.inf if self.best is None else self.best.total

    @property
    def leads_down(self) -> bool:
        """It has been below where it began."""
        return self.total < self.to_beat

    def reaches(self, at: Point | None, gradient: Callable[[Point], Array]) -> None:
        """Go on from a place; None: there is no such rotor.  gradient: by the Jacobian of the beginning."""
        if at is not None and at.total < self.total:
            self.best = at
            back = self.strong.T @ gradient(at) / self.weight
            rise = at.total - self.begun
            if not float(self.weight @ back**2) > max(LIMITS.settled_chi2, LIMITS.worth_returning * rise):
                self.ended = True
                return
            self.backs.append(back)
            self.went.append(accelerated(self.backs, self.went, np.sqrt(self.weight)))
        elif len(self.went) > 1:  # once more without acceleration
            self.backs, self.went = self.backs[-1:], self.backs[-1:]
        else:
            self.ended = True
            return
        assert self.best is not None
        self.next_values = self.layout.moved(self.best.values, self.strong @ self.went[-1])


def accelerated(backs: Sequence[Array], went: Sequence[Array], scale: Array) -> Array:
    """The next step back (k,) by Anderson's acceleration.

    The Jacobian of the point before belongs to another place of a bent valley, so that each step back by it, `backs`,
    leaves a share of the way.  What the steps that were gone, `went`, made of it tells that share.

    scale: (k,) by which a step's components are compared.
    """
    back = backs[-1]
    if not went:
        return back
    fell = np.stack([b - a for a, b in pairwise(backs)], axis=1)
    share = np.linalg.lstsq(scale[:, None] * fell, scale * back, rcond=LIMITS.acceleration_share)[0]
    return np.asarray(back - (np.stack(went, axis=1) + fell) @ share)


def strong_directions(matrix: Array, share: float) -> tuple[Array, Array]:
    """Columns (size, k) along which the data tell most, and what they tell of a unit of each, (k,).

    share: of the largest eigenvalue of the scaled matrix, above which a direction is one of them.

    Raises RotorFitError.
    """
    size = np.diag(matrix)
    if not np.all(size > 0.0):
        raise RotorFitError("the shots do not determine the rotor's parameters")
    scale = 1.0 / np.sqrt(size)
    values, vectors = np.linalg.eigh(matrix * np.outer(scale, scale))
    strong = values > share * values[-1]
    return scale[:, None] * vectors[:, strong], values[strong]
