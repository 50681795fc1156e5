"""The receive side: switch, LNA, receive chain and noise."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Self

from pydantic import Field, model_validator

from sim_backend.hidden_effects.signals import check_distinct
from sim_backend.section import Finite, NonNegative, Positive, Section

Vector = Annotated[tuple[Finite, Finite, Finite], Field(strict=False)]
Levels = Annotated[tuple[NonNegative, NonNegative, NonNegative], Field(strict=False)]
Poles = Annotated[tuple[Positive, ...], Field(strict=False)]


class SwitchOptions(Section):
    """The relay of the Tx/Rx switch.

    dead_time_s, bounce_s, settle_s: dead, bounce and settling time, s; bounces: number of bounces; isolation_db: of the
    receiver while the relay is on transmit; transient_v, transient_tau_s: amplitude at the LNA output, V, and time
    constant, s, of the transient after every closing of the receive contact.
    """

    dead_time_s: Positive
    bounce_s: NonNegative
    settle_s: NonNegative
    bounces: Annotated[int, Field(ge=0, le=20)]
    isolation_db: NonNegative
    transient_v: Vector
    transient_tau_s: Positive

    def worn(self, times: int) -> SwitchOptions:
        """The same relay with `times` as many bounces in `times` the bounce time."""
        worse = {"bounce_s": self.bounce_s * times, "bounces": max(self.bounces, 1) * times}
        return self.model_copy(update=worse)


class LnaOptions(Section):
    """The low-noise amplifier.

    gains: selectable gains, V/V, ascending; output_limit_v: the output saturates there, V; overload_v: output from
    which the LNA reports overload, V.
    """

    gains: Annotated[tuple[Positive, ...], Field(strict=False, min_length=1)]
    output_limit_v: Positive
    overload_v: Positive

    @model_validator(mode="after")
    def _rising(self) -> Self:
        if any(b <= a for a, b in pairwise(self.gains)):
            raise ValueError("gains must rise")
        return self


class ChainOptions(Section):
    """Frequency response of the receive chain, per channel.

    poles_hz: first-order poles, Hz, empty: flat; residual_delay_s: the part of the card's decimation delay that remains
    after compensation to the nearest sample, s.
    """

    poles_hz: Annotated[tuple[Poles, Poles, Poles], Field(strict=False)]
    residual_delay_s: Levels

    @model_validator(mode="after")
    def _distinct(self) -> Self:
        for poles in self.poles_hz:
            check_distinct(poles)
        return self


class ReceiveOptions(Section):
    """The named receive chains, and the one in use."""

    chain: str
    chains: dict[str, ChainOptions]

    @model_validator(mode="after")
    def _exists(self) -> Self:
        if self.chain not in self.chains:
            raise ValueError(f"chain {self.chain!r} is none of {sorted(self.chains)}")
        return self

    def in_place(self) -> ChainOptions:
        """The chain in use."""
        return self.chains[self.chain]


class ColourOptions(Section):
    """Coloured noise with a power density proportional to 1 + (corner_hz / f)^exponent per channel; the total rms is
    unchanged."""

    enabled: bool
    corner_hz: Levels
    exponent: Annotated[float, Field(ge=0, le=4, allow_inf_nan=False)]


class HumOptions(Section):
    """Mains hum, continuous in world time.

    frequency_hz: fundamental, Hz; amplitude_am2_per_s: peak amplitude referred to dm/dt for each harmonic 1, 2, ... and
    channel, A m^2/s.
    """

    enabled: bool
    frequency_hz: Positive
    amplitude_am2_per_s: Annotated[tuple[Levels, ...], Field(strict=False)]


class NoiseOptions(Section):
    """Noise of each channel.

    sd_am2_per_s: rms over the full band at the ADC, referred to dm/dt by the channel's own sensitivity, A m^2/s; scale:
    factor on it, 0: no noise.
    """

    sd_am2_per_s: Levels
    scale: NonNegative
    colour: ColourOptions
    hum: HumOptions
