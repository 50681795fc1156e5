"""Errors and additions of the receive side that the calibration does not contain.

Amplitudes are peak values in A m^2/s, referred to dm/dt by the channel's own sensitivity.  u is a voltage, V.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import pi
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, model_validator

from sim_backend.section import Count, Finite, NonNegative

from .base import Effect, Time

Axis = Literal["x", "y", "z"]
CHANNELS = 3
Frequency = Annotated[float, Field(gt=0, lt=30e3, allow_inf_nan=False)]
Share = Annotated[float, Field(gt=-1, le=1, allow_inf_nan=False)]


def _mains(frequency_hz: float) -> float:
    if frequency_hz not in (50.0, 60.0):
        raise ValueError("mains have 50 or 60 Hz; any other steady tone is a spectral_line")
    return frequency_hz


class SignalEffect(Effect):
    """An effect of the receive side; the list may contain several of one class."""

    ONCE = False


class ChannelGain(SignalEffect):
    """The voltage u is multiplied by 1 + g in one channel or in all, at all frequencies or in one band (one harmonic).

    The gain is full inside frequency_hz +- width_hz / 4 and zero outside frequency_hz +- width_hz / 2.
    """

    UNIT = "1"
    id: Literal["channel_gain"]
    strength: Share
    axis: Axis | None = None
    frequency_hz: Frequency | None = None
    width_hz: Annotated[float, Field(ge=20, allow_inf_nan=False)] | None = None

    @model_validator(mode="after")
    def _band(self) -> ChannelGain:
        if (self.frequency_hz is None) != (self.width_hz is None):
            raise ValueError("frequency_hz and width_hz go together")
        if self.axis is None and self.frequency_hz is None:
            raise ValueError("give an axis, a frequency_hz, or both: a gain of everything is a moment")
        return self


class ChannelDelay(SignalEffect):
    """The rotor's signal arrives later, in one channel or in all."""

    UNIT = "s"
    id: Literal["channel_delay"]
    strength: Annotated[float, Field(ge=0, le=1e-2, allow_inf_nan=False)]
    axis: Axis | None = None


class ReceiveLowpass(SignalEffect):
    """One channel, or all, has one more pole, 1 / (1 + i w tau); the strength is tau."""

    UNIT = "s"
    id: Literal["receive_lowpass"]
    strength: Annotated[float, Field(ge=1e-9, le=1, allow_inf_nan=False)]
    axis: Axis | None = None


class ReceiverCompression(SignalEffect):
    """The voltage u at the ADC becomes u (1 - c u^2); beyond the maximum of this curve the output saturates."""

    UNIT = "1/V^2"
    id: Literal["receiver_compression"]
    strength: Annotated[float, Field(ge=-100, le=100, allow_inf_nan=False)]
    axis: Axis | None = None


class Crosstalk(SignalEffect):
    """A fraction of the rotor's voltage in the channel `from` is added to `to`, before gain errors and poles."""

    UNIT = "1"
    id: Literal["crosstalk"]
    strength: Share
    source: Annotated[Axis, Field(alias="from")]
    target: Annotated[Axis, Field(alias="to")]

    @model_validator(mode="after")
    def _two(self) -> Crosstalk:
        if self.source == self.target:
            raise ValueError("'from' and 'to' must be different channels")
        return self


class MainsInterference(SignalEffect):
    """Mains hum at frequency_hz, continuous in world time.

    harmonics: amplitudes of the harmonics 1, 2, ..., relative to the strength.
    """

    UNIT = "A m^2/s"
    id: Literal["mains_interference"]
    strength: NonNegative
    frequency_hz: Annotated[float, AfterValidator(_mains)]
    axis: Axis | None = None
    harmonics: Annotated[tuple[NonNegative, ...], Field(strict=False, min_length=1)] = (1.0,)


class SpectralLine(SignalEffect):
    """A steady tone, continuous in world time, so that its phase differs from shot to shot."""

    UNIT = "A m^2/s"
    id: Literal["spectral_line"]
    strength: NonNegative
    frequency_hz: Frequency
    axis: Axis | None = None


class SideMode(SignalEffect):
    """A decaying oscillation from the first RX sample on.

    strength: amplitude at the first RX sample; phase_rad: phase of the cosine there, 0 is its maximum.
    """

    UNIT = "A m^2/s"
    id: Literal["side_mode"]
    strength: NonNegative
    frequency_hz: Frequency
    tau_s: Time
    axis: Axis
    phase_rad: Finite = 0.0


class SwitchTransient(SignalEffect):
    """A decaying offset; the strength is its value at the first RX sample."""

    UNIT = "A m^2/s"
    id: Literal["switch_transient"]
    tau_s: Time
    axis: Axis | None = None


class ClockGap(SignalEffect):
    """From the RX sample `sample` on, the data are those of `strength` samples later; the card reports no gap."""

    UNIT = "samples"
    id: Literal["clock_gap"]
    strength: Annotated[int, Field(ge=1, le=10_000)]
    sample: Count


def rows(axis: str | None) -> list[int]:
    """Indices of the channels of an axis; None: all channels."""
    return list(range(CHANNELS)) if axis is None else ["xyz".index(axis)]


def extra_poles_hz(effects: Sequence[Effect], channel: int) -> tuple[float, ...]:
    """Poles that hidden low-passes add to a channel, Hz."""
    mine = [e for e in effects if isinstance(e, ReceiveLowpass) and channel in rows(e.axis)]
    return tuple(1 / (2 * pi * e.strength) for e in mine)


def check_distinct(poles_hz: Sequence[float]) -> None:
    """Raise ValueError if two poles of a channel are too close for partial fractions."""
    if any(b < 1.02 * a for a, b in pairwise(sorted(poles_hz))):
        raise ValueError("poles of one channel must differ by at least 2 %")
