"""Ring-down models as data: a name and the torque terms that act between two turning points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .arrays import IntArray
from .terms import HERTZ_FRICTION, MAGNETIC_RESTORING, VISCOUS_DAMPING, Coefficient, TorqueTerm


@dataclass(frozen=True)
class RingDownModel:
    """An equation of motion: the sum of its torque terms (in units of I w^2)."""

    name: str
    terms: tuple[TorqueTerm, ...]

    @cached_property
    def coefficients(self) -> tuple[Coefficient, ...]:
        """The coefficients of all terms in kernel order."""
        return tuple(c for term in self.terms for c in term.coefficients)

    @cached_property
    def codes(self) -> IntArray:
        """Numbers of the terms for the kernel's dispatch, int64 (terms,)."""
        return np.array([term.code for term in self.terms], dtype=np.int64)

    @cached_property
    def widths(self) -> IntArray:
        """Number of coefficients of each term, int64 (terms,)."""
        return np.array([len(term.coefficients) for term in self.terms], dtype=np.int64)

    @cached_property
    def symmetric(self) -> bool:
        """True if the motion to either side is the mirror image of the other."""
        return all(term.symmetric for term in self.terms)


THREAD = RingDownModel("thread", (MAGNETIC_RESTORING, VISCOUS_DAMPING))
JEWEL = RingDownModel("jewel", (MAGNETIC_RESTORING, VISCOUS_DAMPING, HERTZ_FRICTION))
MODELS = {model.name: model for model in (THREAD, JEWEL)}


def model_named(name: str) -> RingDownModel:
    """The declared model of this name; ValueError lists the known ones."""
    if name not in MODELS:
        raise ValueError(f"unknown variant {name!r}: expected one of {', '.join(sorted(MODELS))}")
    return MODELS[name]


def richer_models(model: RingDownModel) -> tuple[RingDownModel, ...]:
    """Declared models that contain all terms of this one, and more."""
    return tuple(m for m in MODELS.values() if set(m.terms) > set(model.terms))
