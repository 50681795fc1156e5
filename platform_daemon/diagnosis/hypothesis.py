"""A declared model together with the effects that are supposed to act as well, and how their strengths are stored."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from platform_daemon.estimation.arrays import Array
from platform_daemon.estimation.gauss_newton import FitState
from platform_daemon.estimation.models import RingDownModel

from .effects.base import Candidate
from .shots import Shot


@dataclass(frozen=True)
class Hypothesis:
    """Effects beside a declared model; torque effects come first, and strengths are kept in this order."""

    model: RingDownModel
    effects: tuple[Candidate, ...] = ()

    def __post_init__(self) -> None:
        ordered = sorted(self.effects, key=lambda c: c.term is None)
        object.__setattr__(self, "effects", tuple(ordered))

    def plus(self, *effects: Candidate) -> Hypothesis:
        """With further effects."""
        return Hypothesis(self.model, (*self.effects, *effects))

    @cached_property
    def torques(self) -> tuple[Candidate, ...]:
        """Effects in the equation of motion."""
        return tuple(c for c in self.effects if c.term is not None)

    @cached_property
    def signals(self) -> tuple[Candidate, ...]:
        """Effects on the receive side."""
        return tuple(c for c in self.effects if c.term is None)

    @cached_property
    def augmented(self) -> RingDownModel:
        """The declared model with the torque terms of the effects."""
        terms = [c.term for c in self.torques if c.term is not None]
        return self.model.with_terms("+".join([self.model.name, *(t.name for t in terms)]), *terms) if terms else self.model

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        """Where the strengths of each effect stand among all of them."""
        ends = np.cumsum([0, *(c.size for c in self.effects)])
        return tuple(slice(int(a), int(b)) for a, b in zip(ends, ends[1:], strict=False))

    @property
    def size(self) -> int:
        """Number of strengths."""
        return sum(c.size for c in self.effects)

    @cached_property
    def strength_places(self) -> tuple[int, ...]:
        """Parameters of the augmented FitState that are strengths, one per torque effect."""
        places, place = [], 3 + len(self.model.coefficients)
        for c in self.torques:
            assert c.term is not None
            places.append(place)
            place += len(c.term.coefficients)
        return tuple(places)

    def declared(self, size: int) -> np.ndarray:
        """Parameters of an augmented FitState of this size that each shot has for itself, bool (size,)."""
        mask = np.ones(size, dtype=bool)
        first = 3 + len(self.model.coefficients)
        mask[first : 3 + len(self.augmented.coefficients)] = False
        return mask

    def extended(self, state: FitState, strengths: Array) -> FitState:
        """A state of the declared model as one of the augmented model."""
        values = [*state.dynamics.values[: len(self.model.coefficients)]]
        for c, where in zip(self.torques, self.slices, strict=False):
            values += [float(strengths[where.start]), *c.hidden]
        return replace(state, dynamics=replace(state.dynamics, values=tuple(values)))

    def freed(self, shot: Shot, strengths: Array) -> Array:
        """The shot's samples (channels, n) without what the signal effects did to them."""
        samples = shot.record.samples
        for c, where in zip(self.effects, self.slices, strict=True):
            if c.undo is not None and np.any(strengths[where] != 0.0):
                samples = c.undo(samples, shot, strengths[where])
        return samples
