"""Torques with internal state variables, for which the diagnosis has no candidate.

phi: angle of the rotor, rad; w = 2 pi f_nat; a prime is a time derivative.  Torques are per inertia.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from sim_backend.section import NonNegative

from .base import Effect

MemoryTime = Annotated[float, Field(ge=1e-4, allow_inf_nan=False)]  # shorter ones are stiff, and mere damping
ModeFrequency = Annotated[float, Field(gt=1, le=5e3, allow_inf_nan=False)]


class MemoryRelaxation(Effect):
    """A Maxwell element between rotor and bearing exerts the torque -z with z' = k w^2 phi' - z / tau."""

    UNIT = "1"
    id: Literal["memory_relaxation"]
    strength: Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
    tau_s: MemoryTime


class MemoryBristle(Effect):
    """Dahl friction exerts the torque -a z / reach with z' = phi' - |phi'| z / reach; it slips at the level a."""

    UNIT = "rad/s^2"
    id: Literal["memory_bristle"]
    strength: NonNegative
    reach_rad: Annotated[float, Field(ge=1e-4, le=3, allow_inf_nan=False)]


class MemoryAmplitude(Effect):
    """A stiffening that relaxes: torque -k w^2 y phi with y' = 2 phi phi' - y / tau, so y follows phi^2 and decays."""

    UNIT = "1/rad^2"
    id: Literal["memory_amplitude"]
    strength: Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
    tau_s: MemoryTime


class BreathingGap(Effect):
    """The distance of the magnets is d (1 + x): the restoring torque is divided by (1 + x)^3.

    The axial force (eq:fm(phi)) drives the gap: x'' = W^2 (s (1 - cos phi / (1 + x)^4) - x) - 2 g x' with the stretch s
    by the axial force at phi = 0, W = 2 pi frequency_hz and g = decay_per_s.  Where the motion is slow against W, the
    effect equals a restoring anharmonicity beta = 3 s.
    """

    UNIT = "1"
    id: Literal["breathing_gap"]
    strength: Annotated[float, Field(ge=0, le=0.15, allow_inf_nan=False)]
    frequency_hz: ModeFrequency
    decay_per_s: NonNegative


class SecondMode(Effect):
    """A second oscillator y'' = -W^2 y - 2 g y' + c w^2 phi^order / order exerts the torque c w^2 y phi^(order - 1).

    Order 1 exchanges energy near f, order 2 near 2 f.  W = 2 pi frequency_hz must exceed 2 |c| w, because otherwise the
    coupled system is unstable.
    """

    UNIT = "1"
    id: Literal["second_mode"]
    strength: Annotated[float, Field(ge=-0.2, le=0.2, allow_inf_nan=False)]
    frequency_hz: ModeFrequency
    decay_per_s: NonNegative
    order: Literal[1, 2]
