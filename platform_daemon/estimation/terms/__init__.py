"""Torque terms: each a small module with its derivatives; TERMS lists them by name."""

from __future__ import annotations

from .base import Coefficient, TorqueTerm
from .hertz_friction import HERTZ_FRICTION
from .magnetic_restoring import MAGNETIC_RESTORING
from .viscous_damping import VISCOUS_DAMPING

TERMS: dict[str, TorqueTerm] = {t.name: t for t in (MAGNETIC_RESTORING, VISCOUS_DAMPING, HERTZ_FRICTION)}

__all__ = ["HERTZ_FRICTION", "MAGNETIC_RESTORING", "TERMS", "VISCOUS_DAMPING", "Coefficient", "TorqueTerm"]
