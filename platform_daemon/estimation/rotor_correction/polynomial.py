"""Polynomials of several variables in a box, by least squares."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array, IntArray
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.rotor_correction


@dataclass(frozen=True, eq=False)
class Box:
    """Where variables lie: low and high, (k,); bent: number of the one that needs higher powers than the others."""

    low: Array
    high: Array
    bent: int

    @classmethod
    def around(cls, places: Array, bent: int) -> Box:
        """The smallest box that holds places (m, k)."""
        return cls(places.min(axis=0), places.max(axis=0), bent)

    def inside(self, place: Array) -> Array:
        """A place (k,) in the box, from -1 to 1 in each variable."""
        return np.asarray(2.0 * (place - self.low) / (self.high - self.low) - 1.0)

    def terms(self, places: Array) -> Array:
        """All products of two variables, and powers of the bent one, also times another: (m, k) -> (m, terms)."""
        u, bent = self.inside(places), self.bent
        one, other, others = _numbers(u.shape[1], bent)
        powers = u[:, bent, None] ** np.arange(2, LIMITS.most_power + 1)  # the square is one of the products too
        mixed = powers[:, : LIMITS.most_mixed_power - 1, None] * u[:, None, others]
        found = (np.ones((len(u), 1)), u, u[:, one] * u[:, other], powers[:, 1:], mixed.reshape(len(u), -1))
        return np.concatenate(found, axis=1)


@cache
def _numbers(k: int, bent: int) -> tuple[IntArray, IntArray, IntArray]:
    """Of the variables in all products of two, (products,) each, and of all but the bent one, (k - 1,)."""
    one, other = np.triu_indices(k)
    return one, other, np.delete(np.arange(k), bent)


@dataclass(frozen=True, eq=False)
class Polynomial:
    """Of a place in a box; coefficients: (terms, ...)."""

    box: Box
    coefficients: Array

    @classmethod
    def fitted(cls, box: Box, places: Array, values: Array, weights: Array | None = None) -> Polynomial:
        """To values (m, ...) at places (m, k); weights: (m,)."""
        terms, flat = box.terms(places), values.reshape(len(values), -1)
        if weights is not None:
            terms, flat = terms * weights[:, None], flat * weights[:, None]
        tiny = LIMITS.ridge * len(terms) * np.eye(terms.shape[1])
        found = np.linalg.solve(terms.T @ terms + tiny, terms.T @ flat)
        return cls(box, np.asarray(found.reshape(-1, *values.shape[1:]), dtype=np.float64))

    def at(self, place: Array) -> Array:
        """Its values (...) at one place (k,)."""
        return np.asarray(np.tensordot(self.box.terms(place[None])[0], self.coefficients, 1))

    def slope(self, place: Array) -> Array:
        """Its derivatives (..., k) at one place (k,), by central differences."""
        steps = LIMITS.difference_share * (self.box.high - self.box.low) * np.eye(len(place))
        terms = self.box.terms(np.concatenate([place + steps, place - steps]))
        values = np.tensordot(terms, self.coefficients, 1)
        rise = (values[: len(place)] - values[len(place) :]).T
        return np.asarray(rise / (2.0 * np.diag(steps)))
