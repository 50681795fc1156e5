"""The list of undeclared effects as it stands in the configuration."""

from __future__ import annotations

from collections import Counter
from typing import Annotated, TypeVar

from pydantic import AfterValidator, Field

from .base import Effect
from .hidden_states import BreathingGap, MemoryAmplitude, MemoryBristle, MemoryRelaxation, SecondMode
from .signals import (
    ChannelDelay,
    ChannelGain,
    ClockGap,
    Crosstalk,
    MainsInterference,
    ReceiveLowpass,
    ReceiverCompression,
    SideMode,
    SpectralLine,
    SwitchTransient,
)
from .torques import (
    AngleDependentDamping,
    BiasTorque,
    CoulombFriction,
    FrequencyDrift,
    HertzFriction,
    QuadraticDrag,
    RestoringAnharmonicity,
    StribeckFriction,
    TorsionStiffness,
)

AnyEffect = (
    CoulombFriction
    | HertzFriction
    | StribeckFriction
    | QuadraticDrag
    | AngleDependentDamping
    | RestoringAnharmonicity
    | TorsionStiffness
    | BiasTorque
    | FrequencyDrift
    | MemoryRelaxation
    | MemoryBristle
    | MemoryAmplitude
    | BreathingGap
    | SecondMode
    | ChannelGain
    | ChannelDelay
    | ReceiveLowpass
    | ReceiverCompression
    | Crosstalk
    | MainsInterference
    | SpectralLine
    | SideMode
    | SwitchTransient
    | ClockGap
)


def _each_once(effects: tuple[Effect, ...]) -> tuple[Effect, ...]:
    counts = Counter(e.id for e in effects if e.ONCE)  # type: ignore[attr-defined]
    twice = sorted(name for name, count in counts.items() if count > 1)
    if twice:
        raise ValueError(f"{', '.join(twice)} may stand here only once")
    return effects


Undeclared = Annotated[
    tuple[Annotated[AnyEffect, Field(discriminator="id")], ...],
    Field(strict=False),
    AfterValidator(_each_once),
]
"""The list as it stands in the configuration."""

Kind = TypeVar("Kind", bound=Effect)


def first(effects: Undeclared, kind: type[Kind]) -> Kind | None:
    """The effect of a kind that may stand there once; None if it does not."""
    return next((e for e in effects if isinstance(e, kind)), None)


def strength(effects: Undeclared, kind: type[Effect]) -> float:
    """Its strength, 0 if it is absent."""
    found = first(effects, kind)
    return found.strength if found else 0.0
