"""The list of hidden effects in the configuration."""

from __future__ import annotations

from collections import Counter
from typing import Annotated, TypeVar

from pydantic import AfterValidator, Field

from .base import Effect
from .internal_states import BreathingGap, MemoryAmplitude, MemoryBristle, MemoryRelaxation, SecondMode
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
    FrequencyFluctuation,
    FrictionFluctuation,
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
    | FrictionFluctuation
    | QuadraticDrag
    | AngleDependentDamping
    | RestoringAnharmonicity
    | TorsionStiffness
    | BiasTorque
    | FrequencyDrift
    | FrequencyFluctuation
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


HiddenEffects = Annotated[
    tuple[Annotated[AnyEffect, Field(discriminator="id")], ...],
    Field(strict=False),
    AfterValidator(_each_once),
]
"""The list of effects, as the key `undeclared` of `[backends.simulated]` gives it."""

Kind = TypeVar("Kind", bound=Effect)


def first(effects: HiddenEffects, kind: type[Kind]) -> Kind | None:
    """The first effect of a class; None if the list has none."""
    return next((e for e in effects if isinstance(e, kind)), None)


def strength(effects: HiddenEffects, kind: type[Effect]) -> float:
    """The strength of the first effect of a class, in its UNIT; 0 if the list has none."""
    found = first(effects, kind)
    return found.strength if found else 0.0
