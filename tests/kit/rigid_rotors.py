"""Rotors with five degrees of freedom for tests: shipped specimens with other tables, and how to read their state."""

from __future__ import annotations

import tomllib
from typing import Any

import numpy as np

from drivers.specimen import Specimen
from sim_backend.rotor.rigid_body.acceleration import BODY_MOMENT, dipole, turned
from sim_backend.rotor.rigid_body.parameters import body_parameters
from sim_backend.rotor.rotor import Rotor, effective
from tests.kit.data import CONFIG

WEIGHTLESS = [0.0, 0.0, 0.0]


def rigid_specimen(name: str, gravity: list[float] = WEIGHTLESS, side: float = 0.0, **tables: Any) -> Specimen:
    """A shipped single-axis specimen as a rigid body; tables: defects, and updates of its other tables."""
    shipped = tomllib.loads((CONFIG / "resonators" / f"{name}.toml").read_text())
    shipped["rotor"] = {"model": "rigid_body", "gravity_m_per_s2": gravity, "side_damping_per_s": side}
    for key, table in tables.items():
        shipped[key] = {**shipped.get(key, {}), **table}
    return Specimen.model_validate(shipped)


def rigid(name: str, **more: Any) -> tuple[Rotor, np.ndarray]:
    """The rotor and its parameters; see `rigid_specimen`."""
    rotor = effective(rigid_specimen(name, **more))
    return rotor, body_parameters(rotor)


def moment(y: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Unit vector of the moment in a state, (3,)."""
    m = p[BODY_MOMENT : BODY_MOMENT + 3]
    return np.array(turned(y, *(m / np.linalg.norm(m))))


def centre(y: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Place of the rotor's centre in a state, (3,) m."""
    held = p[5:8] - p[3] * y[:3]
    return held if p[0] else held - p[4] * np.array(turned(y, 0.0, 0.0, 1.0))


def energy_j(y: np.ndarray, p: np.ndarray) -> float:
    """Kinetic, magnetic and potential energy of a state."""
    velocity = -p[3] * y[3:6]
    if not p[0]:
        velocity = velocity - p[4] * np.cross(y[10:], turned(y, 0.0, 0.0, 1.0))
    m = moment(y, p) * np.linalg.norm(p[14:17])
    field = np.array(dipole(p, *centre(y, p), *m)[3:])
    kinetic = 0.5 * p[1] * velocity @ velocity + 0.5 * p[2] * y[10:] @ y[10:]
    return float(kinetic - m @ field - p[17:20] @ centre(y, p))
