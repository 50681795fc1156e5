"""What changes from shot to shot by itself, the thermometer that sees some of it, and what goes wrong when."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from sim_backend.section import Count, Finite, NonNegative, Positive, Section

Shots = Annotated[tuple[Count, ...], Field(strict=False)]


class TemperatureEffect(Section):
    """Temperature at the resonator: mean_c, and a fluctuation of sd_k with correlation_time_s (Ornstein-Uhlenbeck).

    It moves f_nat by f_nat_hz_per_k and m_r by m_r_per_k (relative) away from their values at mean_c.  Not enabled:
    the temperature stays at mean_c.
    """

    enabled: bool
    mean_c: Annotated[float, Field(ge=-50, le=150, allow_inf_nan=False)]
    sd_k: NonNegative
    correlation_time_s: Positive
    f_nat_hz_per_k: Finite
    m_r_per_k: Finite


class FrictionScatterEffect(Section):
    """Jewel: T_f is multiplied by a lognormal factor of mean 1 and relative_sd, new for every shot."""

    enabled: bool
    relative_sd: NonNegative


class WearEffect(Section):
    """Jewel: T_f grows by relative_per_shot of its first value with every shot since the specimen was mounted."""

    enabled: bool
    relative_per_shot: NonNegative


class BackActionEffect(Section):
    """Braking by the current the rotor drives through the closed transmit loop, times scale; 1 is physics."""

    enabled: bool
    scale: NonNegative


class EffectsOptions(Section):
    """All effects that can be switched."""

    temperature: TemperatureEffect
    friction_scatter: FrictionScatterEffect
    wear: WearEffect
    back_action: BackActionEffect


class ThermometerOptions(Section):
    """Sensor: noise K rms, resolution K (0: none), offset K."""

    noise_k: NonNegative
    resolution_k: NonNegative
    offset_k: Finite


class FaultOptions(Section):
    """Shots (numbered from 1 since construction) at which something goes wrong; see sim_backend/world/faults.py."""

    overwritten: Shots = ()
    corrupted: Shots = ()
    lost_steps: Shots = ()
    dropped_samples: Shots = ()
    card_timeout: Shots = ()
    amplifier_trip: Shots = ()
    switch_stuck: Shots = ()
    switch_welded: Shots = ()
    relay_bounce: Shots = ()
    lna_overload: Shots = ()
    adc_clip: Shots = ()
