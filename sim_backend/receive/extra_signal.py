"""Hidden effects of the receive side, applied to the simulated voltages.

The order is crosstalk, gain, poles and delay of the rotor's voltages; then the additive signals; then compression.
Noise, LNA limit and ADC follow in `receiver`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

from sim_backend.hidden_effects.base import Effect
from sim_backend.hidden_effects.signals import (
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
from sim_backend.options import ChainOptions, HumOptions
from sim_backend.rotor.pieces import LENGTH, START

from .chain import receive_v
from .noise import hum_v
from .shot_setup import ShotSetup

LINES = 15
RINGING = 10.0  # times 1/width: how long a band filter rings
SHORTEST_TAIL_S = 0.02

Effects = Sequence[Effect]


def mixing_matrix(effects: Effects) -> NDArray[np.float64]:
    """Matrix (3, 3) from voltages at the coils to those of the channels: crosstalk, and gains of all frequencies."""
    cross, gain = np.eye(CHANNELS), np.ones(CHANNELS)
    for e in effects:
        if isinstance(e, Crosstalk):
            cross[rows(e.target), rows(e.source)] += e.strength
        if isinstance(e, ChannelGain) and e.frequency_hz is None:
            gain[rows(e.axis)] *= 1 + e.strength
    return gain[:, None] * cross


def actual_chain(declared: ChainOptions, effects: Effects) -> ChainOptions:
    """The receive chain with the poles and delays that its calibration does not contain."""
    delays = np.array(declared.residual_delay_s)
    for e in effects:
        if isinstance(e, ChannelDelay):
            delays[rows(e.axis)] += e.strength
    poles = tuple(known + extra_poles_hz(effects, k) for k, known in enumerate(declared.poles_hz))
    return declared.model_copy(update={"poles_hz": poles, "residual_delay_s": tuple(delays.tolist())})


def with_clock_gaps(effects: Effects, numbers: NDArray[np.int64], rx_start: int) -> NDArray[np.int64]:
    """Sample numbers (n,) of a record from which the clock gaps are missing."""
    out = numbers.copy()
    for e in effects:
        if isinstance(e, ClockGap):
            out[rx_start + e.sample :] += int(e.strength)
    return out


def margin_s(effects: Effects, rate_hz: float) -> float:
    """Time after the end of a shot for which the motion must be simulated as well, s."""
    gaps = sum(e.strength for e in effects if isinstance(e, ClockGap))
    return gaps / rate_hz + _fade_s(effects)


def _fade_s(effects: Effects) -> float:
    """Ringing time of the narrowest band, s; 0 without bands."""
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
    """Add the effect of gains of single bands to volts (channel, n), in place, while the receiver is connected.

    pieces: motion, see `rotor.motion`; connected: (pieces,) bool; times_s: (n,), s; per_g_v, chain: see
    `chain.receive_v`.  A zero-phase filter takes the band from the voltages that permanently closed contacts would
    give, from before TX to a margin after the end, so that switching leaves no trace in it.
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
    is_connected = connected[np.searchsorted(pieces[:, START], times_s, side="right") - 1]
    places = np.rint(times_s * rate_hz).astype(np.int64)
    for row in range(CHANNELS):
        response = sum((e.strength * _band(e, f) for e in gains if row in rows(e.axis)), np.zeros(f.size))
        volts[row] += is_connected * irfft(response * rfft(whole[row], size), size)[places]


def _band(gain: ChannelGain, f: NDArray[np.float64]) -> NDArray[np.float64]:
    """Response of the band filter at f (n,), Hz: 1 in the inner half of the band, falling to 0 at its edges."""
    assert gain.frequency_hz is not None
    assert gain.width_hz is not None
    place = np.clip(4 * np.abs(f - gain.frequency_hz) / gain.width_hz - 1, 0, 1)
    return np.asarray(np.cos(np.pi / 2 * place) ** 2)


def additive_signals_v(
    setup: ShotSetup, times_s: NDArray[np.float64], per_am2: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Lines, side modes and transients at sample instants (n,), s: (channel, n) float64, V.

    per_am2: (channel,), V per A m^2/s.
    """
    out = np.zeros((CHANNELS, times_s.size))
    since_s = times_s - setup.rx_start_s()
    ringing = since_s > -0.5 / setup.timeline.clock.rate_hz
    since_s = since_s[ringing]
    for k, e in enumerate(setup.options.hidden_effects):
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
    """The options of `noise.hum_v` that produce the effect."""
    harmonics = effect.harmonics if isinstance(effect, MainsInterference) else (1.0,)
    on_channel = [1.0 if k in rows(effect.axis) else 0.0 for k in range(CHANNELS)]
    levels = tuple(tuple(effect.strength * h * on for on in on_channel) for h in harmonics)
    return HumOptions(enabled=True, frequency_hz=effect.frequency_hz, amplitude_am2_per_s=levels)  # type: ignore[arg-type]


def compress(effects: Effects, volts: NDArray[np.float64]) -> None:
    """Replace u by u (1 - c u^2) in volts (channel, n), V, in place; constant beyond the maximum of that curve."""
    for e in effects:
        if isinstance(e, ReceiverCompression):
            for row in rows(e.axis):
                top = (3 * e.strength) ** -0.5 if e.strength > 0 else np.inf
                u = np.clip(volts[row], -top, top)
                volts[row] = u * (1 - e.strength * u**2)
