"""What an instrument may answer to a quantity: forms of calibration curves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from drivers.errors import InputError

from .inputs import Array


class Curve(Protocol):
    """What f an instrument answers to x."""

    @property
    def names(self) -> tuple[str, ...]:
        """Of its parameters."""

    def start(self, x: Array, f: Array) -> Array:
        """Parameters (k,) to begin with, from points (n,)."""

    def value(self, p: Array, x: Array) -> Array:
        """f (n,) at x (n,)."""

    def slope(self, p: Array, x: Array) -> Array:
        """df/dx (n,)."""

    def gradient(self, p: Array, x: Array) -> Array:
        """df/dp (n, k)."""


@dataclass(frozen=True)
class Polynomial:
    """f = sum of p_k z^k with z = (x - centre) / scale."""

    degree: int
    centre: float
    scale: float

    @property
    def names(self) -> tuple[str, ...]:
        """See Curve."""
        return tuple(f"p{k}" for k in range(self.degree + 1))

    def start(self, x: Array, f: Array) -> Array:
        """See Curve."""
        return np.asarray(np.linalg.lstsq(self.gradient(np.empty(0), x), f, rcond=None)[0])

    def value(self, p: Array, x: Array) -> Array:
        """See Curve."""
        return np.asarray(np.polynomial.polynomial.polyval((x - self.centre) / self.scale, p))

    def slope(self, p: Array, x: Array) -> Array:
        """See Curve."""
        derived = np.polynomial.polynomial.polyder(p)
        return np.asarray(np.polynomial.polynomial.polyval((x - self.centre) / self.scale, derived) / self.scale)

    def gradient(self, p: Array, x: Array) -> Array:
        """See Curve."""
        return np.asarray(np.vander((x - self.centre) / self.scale, self.degree + 1, increasing=True))


@dataclass(frozen=True)
class Dipole:
    """f = a (x + x0)^(-3/2): the field of the stator falls with the third power of the distance of the magnets, and the
    frequency is the root of it (paper eq:fnat)."""

    @property
    def names(self) -> tuple[str, ...]:
        """See Curve."""
        return "a", "x0"

    def start(self, x: Array, f: Array) -> Array:
        """See Curve: f^(-2/3) is a straight line of x.  Raises InputError for f that does not fall with x."""
        line = np.polyfit(x, f ** (-2.0 / 3.0), 1)
        if not line[0] > 0.0:
            what, why = "the dipole law does not hold", "the frequency does not fall as the distance grows"
            remedy = "check what the reference reads, or choose another model"
            raise InputError(what, where="measurand", why=why, remedy=remedy)
        return np.array([line[0] ** -1.5, line[1] / line[0]])

    def value(self, p: Array, x: Array) -> Array:
        """See Curve; NaN where the magnets would touch."""
        return np.asarray(p[0] * np.where(x + p[1] > 0.0, x + p[1], np.nan) ** -1.5)

    def slope(self, p: Array, x: Array) -> Array:
        """See Curve."""
        return np.asarray(-1.5 * self.value(p, x) / (x + p[1]))

    def gradient(self, p: Array, x: Array) -> Array:
        """See Curve."""
        return np.stack([self.value(p, x) / p[0], self.slope(p, x)], axis=1)
