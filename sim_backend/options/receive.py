"""The receive side: switch, LNA, receive chain and noise."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Self

from pydantic import Field, model_validator

from sim_backend.section import Finite, NonNegative, Positive, Section
from sim_backend.undeclared.signals import check_distinct

Vector = Annotated[tuple[Finite, Finite, Finite], Field(strict=False)]
Levels = Annotated[tuple[NonNegative, NonNegative, NonNegative], Field(strict=False)]
Poles = Annotated[tuple[Positive, ...], Field(strict=False)]


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
