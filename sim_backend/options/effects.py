"""Variations from shot to shot, the thermometer, and the shots at which faults occur."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from sim_backend.section import Count, Finite, NonNegative, Positive, Section

Shots = Annotated[tuple[Count, ...], Field(strict=False)]


class TemperatureEffect(Section):
    """Temperature at the resonator: mean_c plus an Ornstein-Uhlenbeck process of sd_k and correlation_time_s.

    The temperature shifts f_nat by f_nat_hz_per_k and m_r by m_r_per_k (relative) from their values at mean_c.  If the
    effect is not enabled, the temperature is constant at mean_c.
    """

    enabled: bool
    mean_c: Annotated[float, Field(ge=-50, le=150, allow_inf_nan=False)]
    sd_k: NonNegative
    correlation_time_s: Positive
    f_nat_hz_per_k: Finite
    m_r_per_k: Finite


class FrictionScatterEffect(Section):
    """In a jewel bearing T_f is multiplied by a lognormal factor of mean 1 and relative_sd, new for every shot."""

    enabled: bool
    relative_sd: NonNegative


class WearEffect(Section):
    """In a jewel bearing T_f grows by relative_per_shot of its initial value with every shot since the specimen was
    mounted."""

    enabled: bool
    relative_per_shot: NonNegative


class BackActionEffect(Section):
    """Braking by the current that the rotor induces in the closed transmit loop; scale 1 is the physical value."""

    enabled: bool
    scale: NonNegative


class EffectsOptions(Section):
    """All effects that can be enabled."""

    temperature: TemperatureEffect
    friction_scatter: FrictionScatterEffect
    wear: WearEffect
    back_action: BackActionEffect


class HousingOptions(Section):
    """A housing whose membrane carries the stator, so that f_nat follows the pressure, and that is warmed slowly.

    The pressure is mean_mbar plus a sine of swing_mbar and period_s; f_nat changes by f_nat_hz_per_mbar times its
    deviation d from mean_mbar, and by f_nat_hz_per_mbar2 times d^2.  thermal_time_constant_s: the rotor follows the
    temperature that the thermometer reads with this time constant, 0: at once.
    """

    mean_mbar: Positive = 1013.25
    swing_mbar: NonNegative = 0.0
    period_s: Positive = 3600.0
    f_nat_hz_per_mbar: Finite = 0.0
    f_nat_hz_per_mbar2: Finite = 0.0
    thermal_time_constant_s: NonNegative = 0.0


class ThermometerOptions(Section):
    """Errors of the temperature sensor.

    noise_k: rms noise, K; resolution_k: step of the reading, K, 0: continuous; offset_k: constant error, K.
    """

    noise_k: NonNegative
    resolution_k: NonNegative
    offset_k: Finite


class FaultOptions(Section):
    """Shots at which each fault occurs, numbered from 1 since construction; see sim_backend/world/faults.py."""

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
