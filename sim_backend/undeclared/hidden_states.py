"""Torques with a state of their own, for which no list of candidates has a name."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from sim_backend.section import NonNegative

from .base import Effect

MemoryTime = Annotated[float, Field(ge=1e-4, allow_inf_nan=False)]  # shorter ones are stiff, and mere damping
ModeFrequency = Annotated[float, Field(gt=1, le=5e3, allow_inf_nan=False)]


class MemoryRelaxation(Effect):
    """Maxwell element between rotor and bearing: torque -z with z' = k w^2 phi' - z / tau."""

    UNIT = "1"
    id: Literal["memory_relaxation"]
    strength: Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
    tau_s: MemoryTime


class MemoryBristle(Effect):
    """Dahl friction: torque -a z / reach with z' = phi' - |phi'| z / reach; it slips at the level a."""

    UNIT = "rad/s^2"
    id: Literal["memory_bristle"]
    strength: NonNegative
    reach_rad: Annotated[float, Field(ge=1e-4, le=3, allow_inf_nan=False)]


class MemoryAmplitude(Effect):
    """Stiffening that creeps away: torque -k w^2 y phi with y' = 2 phi phi' - y / tau, so y forgets phi^2."""

    UNIT = "1/rad^2"
    id: Literal["memory_amplitude"]
    strength: Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
    tau_s: MemoryTime


class BreathingGap(Effect):
    """The distance of the magnets is d (1 + x): restoring torque / (1 + x)^3, and with the axial force (eq:fm(phi))

    x'' = W^2 (s (1 - cos phi / (1 + x)^4) - x) - 2 g x'; s: stretch by the axial force at phi = 0, W: 2 pi
    frequency_hz, g: decay_per_s.  Slow against W it acts like beta = 3 s.
    """

    UNIT = "1"
    id: Literal["breathing_gap"]
    strength: Annotated[float, Field(ge=0, le=0.15, allow_inf_nan=False)]
    frequency_hz: ModeFrequency
    decay_per_s: NonNegative


class SecondMode(Effect):
    """A second oscillator y'' = -W^2 y - 2 g y' + c w^2 phi^order / order, with the torque c w^2 y phi^(order - 1).

    order 1: exchanges energy near f; order 2: near 2 f.  W > 2 |c| w, or the two would pull each other over.
    """

    UNIT = "1"
    id: Literal["second_mode"]
    strength: Annotated[float, Field(ge=-0.2, le=0.2, allow_inf_nan=False)]
    frequency_hz: ModeFrequency
    decay_per_s: NonNegative
    order: Literal[1, 2]
