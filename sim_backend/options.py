"""What the simulated platform can be told: the table `[backends.simulated]` and the small tables of its devices.

config/platforms/simulated.toml is the commented original.  Every key is required unless a default stands here.
"""

from __future__ import annotations

from datetime import datetime
from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from drivers.specimen import Position
from sim_backend.section import Count, Finite, NonNegative, Positive, Section
from sim_backend.undeclared.listing import Undeclared
from sim_backend.undeclared.signals import check_distinct, extra_poles_hz

Shots = Annotated[tuple[Count, ...], Field(strict=False)]
Vector = Annotated[tuple[Finite, Finite, Finite], Field(strict=False)]
Levels = Annotated[tuple[NonNegative, NonNegative, NonNegative], Field(strict=False)]
Output = Annotated[int, Field(ge=0, le=2)]
Poles = Annotated[tuple[Positive, ...], Field(strict=False)]


class ClockOptions(Section):
    """`fast`: time passes only when somebody sleeps or reads; `realtime`: like a clock on the wall, `speed` times as
    fast.

    start_utc: time of day at construction, None: this computer's.
    """

    mode: Literal["fast", "realtime"]
    speed: Positive = 1.0
    start_utc: datetime | None = None


class CardOptions(Section):
    """Converters: full scales V (peak), resolution of the ADC in bit."""

    input_full_scale_v: Positive
    output_full_scale_v: Positive
    adc_bits: Annotated[int, Field(ge=4, le=24)]


class AmplifierOptions(Section):
    """Class-D amplifier: voltage gain V/V, output limit V, output impedance ohm, and its heat sink.

    idle_w (while enabled) and loss_fraction of the delivered energy heat a body of heat_capacity_j_per_k that cools
    through cooling_k_per_w; above trip_temperature_c it trips.
    """

    gain: Positive
    limit_v: Positive
    output_impedance_ohm: NonNegative
    idle_w: NonNegative
    loss_fraction: NonNegative
    heat_capacity_j_per_k: Positive
    cooling_k_per_w: Positive
    trip_temperature_c: Finite


class CoilOptions(Section):
    """One Helmholtz pair: loop radius m, turns per loop, distance of the loops m, resistance ohm and inductance H of
    both in series; offset_m moves the pair, axis_error_rad (small Rodrigues vector) tilts it."""

    radius_m: Positive
    turns: Count
    separation_m: Positive
    resistance_ohm: Positive
    inductance_h: Positive
    offset_m: Vector = (0.0, 0.0, 0.0)
    axis_error_rad: Vector = (0.0, 0.0, 0.0)


class CoilsOptions(Section):
    """The three pairs, named by their axis in world coordinates."""

    x: CoilOptions
    y: CoilOptions
    z: CoilOptions

    def in_order(self) -> tuple[CoilOptions, CoilOptions, CoilOptions]:
        """x, y, z."""
        return self.x, self.y, self.z


class SwitchOptions(Section):
    """Relay: dead, bounce and settle time s, number of bounces, isolation dB of the receiver while transmitting, and
    the transient V at the LNA output with its time constant s that follows every closing of the receive contact."""

    dead_time_s: Positive
    bounce_s: NonNegative
    settle_s: NonNegative
    bounces: Annotated[int, Field(ge=0, le=20)]
    isolation_db: NonNegative
    transient_v: Vector
    transient_tau_s: Positive

    def worn(self, times: int) -> SwitchOptions:
        """The same relay, bouncing so many times as long and as often."""
        worse = {"bounce_s": self.bounce_s * times, "bounces": max(self.bounces, 1) * times}
        return self.model_copy(update=worse)


class LnaOptions(Section):
    """gains V/V it can be set to, rising; output_limit_v: its output stops; overload_v: it reports overload."""

    gains: Annotated[tuple[Positive, ...], Field(strict=False, min_length=1)]
    output_limit_v: Positive
    overload_v: Positive

    @model_validator(mode="after")
    def _rising(self) -> Self:
        if any(b <= a for a, b in pairwise(self.gains)):
            raise ValueError("gains must rise")
        return self


class ChainOptions(Section):
    """Frequency response of the receive chain, per channel: first-order poles Hz (empty: flat), and what is left of
    the card's decimation delay after compensation to the nearest sample, s."""

    poles_hz: Annotated[tuple[Poles, Poles, Poles], Field(strict=False)]
    residual_delay_s: Levels

    @model_validator(mode="after")
    def _distinct(self) -> Self:
        for poles in self.poles_hz:
            check_distinct(poles)
        return self


class ReceiveOptions(Section):
    """Which of the named receive chains is in place."""

    chain: str
    chains: dict[str, ChainOptions]

    @model_validator(mode="after")
    def _exists(self) -> Self:
        if self.chain not in self.chains:
            raise ValueError(f"chain {self.chain!r} is none of {sorted(self.chains)}")
        return self

    def in_place(self) -> ChainOptions:
        """The chosen chain."""
        return self.chains[self.chain]


class ColourOptions(Section):
    """Coloured noise: power density proportional to 1 + (corner_hz / f)^exponent per channel, total rms unchanged."""

    enabled: bool
    corner_hz: Levels
    exponent: Annotated[float, Field(ge=0, le=4, allow_inf_nan=False)]


class HumOptions(Section):
    """Mains hum: fundamental Hz and, per harmonic 1, 2, ..., its amplitude per channel in A m^2/s (peak, referred to
    dm/dt); the phase runs on in world time."""

    enabled: bool
    frequency_hz: Positive
    amplitude_am2_per_s: Annotated[tuple[Levels, ...], Field(strict=False)]


class NoiseOptions(Section):
    """Noise per channel: sd_am2_per_s is the rms over the full band at the ADC, referred to dm/dt by the channel's own
    sensitivity; scale multiplies it (0: none)."""

    sd_am2_per_s: Levels
    scale: NonNegative
    colour: ColourOptions
    hum: HumOptions


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


class WiringOptions(Section):
    """How the amplifier is wired, from x, y, z as they should be: the DAC output (0, 1, 2) that each coil hangs on, and
    a factor on each coil's voltage (-1: turned round, 0.5: half the gain, 0: cable open)."""

    outputs: Annotated[tuple[Output, Output, Output], Field(strict=False)] = (0, 1, 2)
    factors: Vector = (1.0, 1.0, 1.0)


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


class SimulatedOptions(Section):
    """The whole table `[backends.simulated]`."""

    seed: Annotated[int, Field(ge=0)]
    clock: ClockOptions
    card: CardOptions
    amplifier: AmplifierOptions
    coils: CoilsOptions
    switch: SwitchOptions
    lna: LnaOptions
    receive: ReceiveOptions
    noise: NoiseOptions
    effects: EffectsOptions
    thermometer: ThermometerOptions
    wiring: WiringOptions = WiringOptions()
    faults: FaultOptions = FaultOptions()
    undeclared: Undeclared = ()

    @model_validator(mode="after")
    def _poles(self) -> Self:
        for channel, poles in enumerate(self.receive.in_place().poles_hz):
            check_distinct(poles + extra_poles_hz(self.undeclared, channel))
        return self


class IoCardTable(Section):
    """`[io_card]`: converter clock Hz, decimation, longest timeline in samples; grid of the edges in samples and step
    of the amplitudes in V (a real card's sequence and registers have steps; 1 and 0: any)."""

    base_frequency_hz: Positive
    decimation: Count
    max_samples: Count
    step_samples: Count = 1
    output_step_v: NonNegative = 0.0


class LnaTable(Section):
    """`[lna]`: gain V/V set at the start."""

    gain: Positive


class CalibrationTable(Section):
    """`[calibration]`: LNA gain V/V it holds for, position m it was made at, highest frequency Hz, name and date; and
    deliberate errors of the calibration, relative per channel (0: exact)."""

    lna_gain: Positive
    position_m: Position
    frequency_max_hz: Positive
    identifier: Annotated[str, Field(min_length=1)]
    date: Annotated[str, Field(min_length=10)]
    gain_error: Vector = (0.0, 0.0, 0.0)


class DipoleTable(Section):
    """`[reference_dipole]`: turns times area A m^2/A and position m of a small coil; resistance ohm and inductance H of
    its loop, fed by the card's `output`, which no coil hangs on; relative_std: of the moment, as told to the daemon.
    """

    output: Annotated[int, Field(ge=3, le=3)]
    turns_area_m2: Positive
    resistance_ohm: Positive
    inductance_h: NonNegative
    relative_std: Annotated[float, Field(ge=0, lt=1)]
    position_m: Position = (0.0, 0.0, 0.0)


class ProbeTable(Section):
    """`[field_probe]`: noise T rms per sample, position m; relative_std: of its sensitivity, as told to the daemon."""

    noise_t: NonNegative
    relative_std: Annotated[float, Field(ge=0, lt=1)]
    position_m: Position = (0.0, 0.0, 0.0)


class EmptyTable(Section):
    """A device table without keys of its own."""
