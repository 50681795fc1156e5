"""Torques per inertia: the columns of every library, each with the sign under which a loss is positive."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array

Torque = Callable[[float, float, float], float]
"""phi'' of (phi, phi', t), rad/s^2."""
# Of the largest speed: below it a dry friction is a steep viscous one, so that rest can be simulated.
_STANDSTILL = 1e-4


@dataclass(frozen=True)
class Column:
    """One torque per unit of strength. scalar: (phi, v, s), s the smooth sign of v; loss: its strength is positive."""

    name: str
    scalar: Callable[[float, float, float], float]
    array: Callable[[Array, Array], Array]
    power: int
    loss: bool = False


def _hertz(phi: float) -> float:
    return max(math.cos(phi), 0.0) ** (4.0 / 3.0)


COLUMNS = {
    c.name: c
    for c in (
        Column("sine", lambda p, v, s: -math.sin(p), lambda p, v: -np.sin(p), 2),
        Column("torsion_stiffness", lambda p, v, s: -p, lambda p, v: -p, 2),
        Column("cubic_restoring", lambda p, v, s: p**3, lambda p, v: p**3, 2),
        Column("viscous_damping", lambda p, v, s: -2.0 * v, lambda p, v: -2.0 * v, 1, True),
        Column("quadratic_drag", lambda p, v, s: -v * abs(v), lambda p, v: -v * np.abs(v), 0, True),
        Column("cubic_drag", lambda p, v, s: -(v**3), lambda p, v: -(v**3), -1, True),
        Column("coulomb_friction", lambda p, v, s: -s, lambda p, v: -np.sign(v), 2, True),
        Column(
            "hertz_friction",
            lambda p, v, s: -s * _hertz(p),
            lambda p, v: -np.sign(v) * np.maximum(np.cos(p), 0.0) ** (4.0 / 3.0),
            2,
            True,
        ),
        Column("bias_torque", lambda p, v, s: 1.0, lambda p, v: np.ones_like(p), 2),
        Column("angle_dependent_damping", lambda p, v, s: -2.0 * p * p * v, lambda p, v: -2.0 * p * p * v, 1),
        Column(
            "restoring_anharmonicity",
            lambda p, v, s: math.sin(p) * (1.0 - math.cos(p)),
            lambda p, v: np.sin(p) * (1.0 - np.cos(p)),
            2,
        ),
    )
}
LIBRARY = tuple(n for n in COLUMNS if n != "restoring_anharmonicity")
"""The ten columns of the peers: the sine and phi^3 span the anharmonicity of small angles."""
ALSO_CALLED = {"cubic_restoring": "restoring_anharmonicity"}


@dataclass(frozen=True)
class Model:
    """What a row says: a torque, the terms it is made of by name (SI), and what of them is declared to begin with.

    gaps: (time in s, seconds lost before it), where a diagnosis says that the clock of the record jumps.
    """

    torque: Torque
    terms: Mapping[str, float]
    speed: float
    gaps: tuple[tuple[float, float], ...] = ()

    def unphysical(self) -> tuple[str, ...]:
        """Losses that feed the motion."""
        return tuple(n for n, c in self.terms.items() if n in COLUMNS and COLUMNS[n].loss and c < 0.0)


def smooth_sign(speed: float) -> Callable[[float], float]:
    """Sign of a velocity; speed: the largest of the record, rad/s."""
    width = _STANDSTILL * speed
    return lambda v: math.tanh(v / width)


def model_of(terms: Mapping[str, float], speed: float) -> Model:
    """A sum of columns, by name and strength in SI."""
    parts = [(c, COLUMNS[n].scalar) for n, c in terms.items() if c != 0.0]
    sign = smooth_sign(speed)

    def torque(phi: float, v: float, t: float) -> float:
        s, total = sign(v), 0.0
        for c, f in parts:
            total += c * f(phi, v, s)
        return total

    return Model(torque, dict(terms), speed)


def scaled(terms: Sequence[tuple[str, float]], w: float) -> dict[str, float]:
    """Strengths in SI of coefficients in units of 1/w."""
    return {n: c * w ** COLUMNS[n].power for n, c in terms}


def effects_named(terms: Mapping[str, float], declared: Sequence[str]) -> tuple[str, ...]:
    """Names beyond the sine and what was declared, as the product calls them."""
    known = {"sine", *declared}
    return tuple(dict.fromkeys(ALSO_CALLED.get(n, n) for n, c in terms.items() if c != 0.0 and n not in known))
