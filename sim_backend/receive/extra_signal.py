"""What nobody declared on the receive side, applied to the simulated volts.

Order: crosstalk, gain, poles and delay of the rotor's voltages; then what adds to them; then compression.  Noise,
LNA limit and ADC follow in `receiver`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

from sim_backend.options import ChainOptions, HumOptions
from sim_backend.rotor.motion import LENGTH, START
from sim_backend.undeclared.base import Effect
from sim_backend.undeclared.signals import (
    CHANNELS,
    ChannelDelay,
    ChannelGain,
    ClockGap,
    Crosstalk,
    MainsInterference,
    ReceiverCompression,
    SideMode,
    SpectralLine,
    SwitchTransient,
    extra_poles_hz,
    rows,
)

from .chain import receive_v
from .noise import hum_v
from .shot_setup import ShotSetup

LINES = 15
RINGING = 10.0  # times 1/width: how long a band filter rings
SHORTEST_TAIL_S = 0.02

Effects = Sequence[Effect]


def mixing(effects: Effects) -> NDArray[np.float64]:
    """(3, 3) float64: volts of the channels from the volts at their coils, gains and crosstalk of all frequencies."""
    cross, gain = np.eye(CHANNELS), np.ones(CHANNELS)
    for e in effects:
        if isinstance(e, Crosstalk):
            cross[rows(e.target), rows(e.source)] += e.strength
        if isinstance(e, ChannelGain) and e.frequency_hz is None:
            gain[rows(e.axis)] *= 1 + e.strength
    return gain[:, None] * cross


def chain_as_built(declared: ChainOptions, effects: Effects) -> ChainOptions:
    """The receive chain with the poles and delays that its calibration does not know."""
    delays = np.array(declared.residual_delay_s)
    for e in effects:
        if isinstance(e, ChannelDelay):
            delays[rows(e.axis)] += e.strength
    poles = tuple(known + extra_poles_hz(effects, k) for k, known in enumerate(declared.poles_hz))
    return declared.model_copy(update={"poles_hz": poles, "residual_delay_s": tuple(delays.tolist())})


def with_gaps(effects: Effects, numbers: NDArray[np.int64], rx_start: int) -> NDArray[np.int64]:
    """Sample numbers (n,) of a record with samples missing."""
    out = numbers.copy()
    for e in effects:
        if isinstance(e, ClockGap):
            out[rx_start + e.sample :] += int(e.strength)
    return out


def listening_tail_s(effects: Effects, rate_hz: float) -> float:
    """How far beyond its end a shot must be known."""
    gaps = sum(e.strength for e in effects if isinstance(e, ClockGap))
    return gaps / rate_hz + _fade_s(effects)


def _fade_s(effects: Effects) -> float:
    """How long the narrowest band rings; 0 without bands."""
    widths = [e.width_hz for e in effects if isinstance(e, ChannelGain) and e.width_hz is not None]
    return max(RINGING / min(widths), SHORTEST_TAIL_S) if widths else 0.0


def add_band_gains(
    effects: Effects,
    pieces: NDArray[np.float64],
    connected: NDArray[np.bool_],
    times_s: NDArray[np.float64],
    rate_hz: float,
    per_g_v: NDArray[np.float64],
    chain: ChainOptions,
    volts: NDArray[np.float64],
) -> None:
    """Add what gains of single bands change to volts (channel, n), while the receiver is connected.

    The band is cut out without phase from the voltages at closed contacts, from before TX to a tail after the end, so
    that switching leaves no trace in it.
    """
    gains = [e for e in effects if isinstance(e, ChannelGain) and e.frequency_hz is not None]
    if not gains or not len(pieces):
        return
    n = int((pieces[-1, START] + pieces[-1, LENGTH]) * rate_hz)
    whole = receive_v(pieces, np.ones(len(pieces), dtype=np.bool_), np.arange(n) / rate_hz, per_g_v, chain)
    beyond = n - 1 - round(times_s[-1] * rate_hz)
    whole[:, n - beyond :] *= np.cos(np.linspace(0, np.pi / 2, beyond)) ** 2
    size = next_fast_len(n + int(_fade_s(effects) * rate_hz), real=True)
    f = rfftfreq(size, 1 / rate_hz)
    heard = connected[np.searchsorted(pieces[:, START], times_s, side="right") - 1]
    places = np.rint(times_s * rate_hz).astype(np.int64)
    for row in range(CHANNELS):
        response = sum((e.strength * _band(e, f) for e in gains if row in rows(e.axis)), np.zeros(f.size))
        volts[row] += heard * irfft(response * rfft(whole[row], size), size)[places]


def _band(gain: ChannelGain, f: NDArray[np.float64]) -> NDArray[np.float64]:
    """1 in the inner half of the band, falling to 0 at its edges."""
    assert gain.frequency_hz is not None
    assert gain.width_hz is not None
    place = np.clip(4 * np.abs(f - gain.frequency_hz) / gain.width_hz - 1, 0, 1)
    return np.asarray(np.cos(np.pi / 2 * place) ** 2)


def additions_v(setup: ShotSetup, times_s: NDArray[np.float64], per_am2: NDArray[np.float64]) -> NDArray[np.float64]:
    """Lines, side modes and transients at sample instants (n,): (channel, n), V; per_am2: (channel,) V per A m^2/s."""
    out = np.zeros((CHANNELS, times_s.size))
    since_s = times_s - setup.rx_start_s()
    ringing = since_s > -0.5 / setup.timeline.clock.rate_hz
    since_s = since_s[ringing]
    for k, e in enumerate(setup.options.undeclared):
        if isinstance(e, SideMode | SwitchTransient):
            shape = np.exp(-since_s / e.tau_s)
            if isinstance(e, SideMode):
                shape *= np.cos(2 * np.pi * e.frequency_hz * since_s + e.phase_rad)
            for row in rows(e.axis):
                out[row, ringing] += e.strength * per_am2[row] * shape
        if isinstance(e, MainsInterference | SpectralLine):
            tones = _tones(e)
            phases = np.random.default_rng([setup.options.seed, 0, LINES, k]).uniform(
                0, 2 * np.pi, (len(tones.amplitude_am2_per_s), CHANNELS)
            )
            out += hum_v(tones, phases, setup.start_s + times_s, per_am2)
    return out


def _tones(effect: MainsInterference | SpectralLine) -> HumOptions:
    """As hum of the declared kind."""
    harmonics = effect.harmonics if isinstance(effect, MainsInterference) else (1.0,)
    heard = [1.0 if k in rows(effect.axis) else 0.0 for k in range(CHANNELS)]
    levels = tuple(tuple(effect.strength * h * on for on in heard) for h in harmonics)
    return HumOptions(enabled=True, frequency_hz=effect.frequency_hz, amplitude_am2_per_s=levels)  # type: ignore[arg-type]


def compress(effects: Effects, volts: NDArray[np.float64]) -> None:
    """u -> u (1 - c u^2) in place, (channel, n) V; constant beyond the top of that curve."""
    for e in effects:
        if isinstance(e, ReceiverCompression):
            for row in rows(e.axis):
                top = (3 * e.strength) ** -0.5 if e.strength > 0 else np.inf
                u = np.clip(volts[row], -top, top)
                volts[row] = u * (1 - e.strength * u**2)
