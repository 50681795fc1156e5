"""Two dipoles in dimensionless form: lengths in units of d, both moments 1, energies in mu_0 m_r^2 / (4 pi d^3).

All functions are analytic, so that complex steps give derivatives to rounding error.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Vectors = NDArray[Any]
"""(n, 3), real, or complex while a derivative is taken."""


def dot(a: Vectors, b: Vectors) -> NDArray[Any]:
    """Scalar products of vectors (n, 3) without conjugation, (n,)."""
    return np.einsum("ni,ni->n", a, b)


def cross(a: Vectors, b: Vectors) -> Vectors:
    """Vector products of vectors (n, 3), (n, 3)."""
    return np.cross(a, b)


def unit(a: Vectors) -> Vectors:
    """Vectors (n, 3) normalised to length 1."""
    return a / np.sqrt(dot(a, a))[:, None]


def stator_field(stator: Vectors, place: Vectors) -> Vectors:
    """Field of a dipole at the origin, (n, 3), in mu_0 m_r / (4 pi d^3)."""
    square = dot(place, place)[:, None]
    along = dot(stator, place)[:, None]
    return (3 * along * place / square - stator) / square**1.5


def dipole_force(stator: Vectors, rotor: Vectors, place: Vectors) -> Vectors:
    """Force on the rotor's dipole at `place`, (n, 3), in mu_0 m_r^2 / (4 pi d^4): gradient of m . B.

    For antiparallel dipoles side by side it is 3, the F_m of paper eq:fm(phi).
    """
    square = dot(place, place)[:, None]
    s, m = dot(stator, place)[:, None], dot(rotor, place)[:, None]
    both = dot(stator, rotor)[:, None]
    return 3 * (s * rotor + m * stator + both * place - 5 * s * m * place / square) / square**2.5


def rotated(vectors: Vectors, turn: Vectors) -> Vectors:
    """Vectors (n, 3) rotated by rotation vectors (n, 3), rad (Rodrigues)."""
    angle = np.sqrt(dot(turn, turn))[:, None]
    sine = np.sinc(angle / np.pi)
    half = np.sinc(angle / (2 * np.pi)) ** 2 / 2
    across = cross(turn, vectors)
    return vectors + sine * across + half * cross(turn, across)
