"""The receive side of a shot: coil EMF, leakage, contact transients, hum and noise, LNA, ADC."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from drivers.tx_rx_switch import SwitchPosition

from .chain import receive_v
from .extra_signal import actual_chain, add_band_gains, additive_signals_v, compress, mixing_matrix, with_clock_gaps
from .inserted import dipole_v
from .noise import hum_v, noise_v
from .shot_setup import NOISE, ShotSetup

OVERLOAD_BURST_S = 5e-3
CLIPPING_S = 1e-3


@dataclass(frozen=True)
class ReceivedSignal:
    """What the ADC recorded.

    volts: (channel, n) float32 at the ADC, multiples of its step; noise_sd_v: (channel,) rms noise including the ADC
    step, V; overload_s: when the LNA first reported overload, s after the trigger, None: never.
    """

    volts: NDArray[np.float32]
    noise_sd_v: NDArray[np.float64]
    overload_s: float | None


def receive_signal(
    setup: ShotSetup,
    pieces: NDArray[np.float64],
    connected: NDArray[np.bool_],
    spans: list[tuple[float, float, SwitchPosition]],
    leak_v: NDArray[np.float64],
    broken_s: float,
) -> ReceivedSignal:
    """Everything that the ADC records in a shot.

    pieces: motion, see `rotor.motion`; connected: (pieces,) bool, whether the receiver is connected; spans: positions
    of the contacts, s after the trigger; leak_v: (channel, m), leakage at the LNA input, V; broken_s: from this time on
    the LNA is destroyed and only noise arrives.
    """
    times = sample_times(setup)
    volts = signal_v(setup, pieces, connected, times)
    if setup.dipole is not None:
        volts += dipole_v(setup, setup.dipole, spans, times)
    leak = leak_v[:, : times.size]
    volts[:, : leak.shape[1]] += setup.lna_gain * leak
    _add_transients(setup, spans, times, volts)
    if setup.options.noise.hum.enabled:
        scale = setup.options.noise.scale * volts_per_am2(setup)
        volts += hum_v(setup.options.noise.hum, setup.hum_phases_rad, setup.start_s + times, scale)
    volts += additive_signals_v(setup, times, volts_per_am2(setup))
    compress(setup.options.hidden_effects, volts)
    if "lna_overload" in setup.faults:
        _add_interference(setup, times, volts)
    volts[:, times >= broken_s] = 0.0
    sd_v = setup.options.noise.scale * np.array(setup.options.noise.sd_am2_per_s) * volts_per_am2(setup)
    total, rate = setup.timeline.total_samples, setup.timeline.clock.rate_hz
    volts += noise_v(setup.rng(NOISE), sd_v, total, rate, setup.options.noise.colour)[:, : times.size]
    overload_s = _limit(setup, times, volts)
    if "adc_clip" in setup.faults:
        _add_clipping(setup, times, volts)
    step_v = adc_step_v(setup)
    return ReceivedSignal(
        digitised(volts, step_v, setup.options.card.adc_bits), np.hypot(sd_v, step_v / 12**0.5), overload_s
    )


def sample_times(setup: ShotSetup) -> NDArray[np.float64]:
    """Instants (n,) of the samples up to the end of the shot, s after the trigger."""
    return sample_numbers(setup) / setup.timeline.clock.rate_hz - setup.delay_s


def sample_numbers(setup: ShotSetup) -> NDArray[np.int64]:
    """Numbers (n,) of the samples that the record contains, up to the end of the shot, counted without clock gaps."""
    numbers = np.arange(min(setup.timeline.total_samples, int(np.ceil(setup.stop_s * setup.timeline.clock.rate_hz))))
    return with_clock_gaps(setup.options.hidden_effects, numbers, setup.timeline.rx_start)


def signal_v(
    setup: ShotSetup, pieces: NDArray[np.float64], connected: NDArray[np.bool_], times_s: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The rotor's signal at the ADC, without noise: (channel, n) float64, V; u = -P dm/dt (eq:u(t,p,R))."""
    if setup.rotor is None:
        return np.zeros((3, times_s.size))
    axes, hidden_effects = setup.rotor.axes, setup.options.hidden_effects
    per_g = mixing_matrix(hidden_effects) @ (-setup.rotor.m_r_am2 * setup.lna_gain * setup.sensitivity_t_per_a @ axes)
    chain = actual_chain(setup.options.receive.in_place(), hidden_effects)
    volts = receive_v(pieces, connected, times_s, per_g, chain)
    add_band_gains(hidden_effects, pieces, connected, times_s, setup.timeline.clock.rate_hz, per_g, chain, volts)
    return volts


def volts_per_am2(setup: ShotSetup) -> NDArray[np.float64]:
    """Each channel's own sensitivity at the ADC, V/(A m^2/s): (3,)."""
    return setup.lna_gain * np.abs(np.diag(setup.sensitivity_t_per_a))


def adc_step_v(setup: ShotSetup) -> float:
    """One ADC code, V."""
    return float(setup.options.card.input_full_scale_v / 2 ** (setup.options.card.adc_bits - 1))


def digitised(volts: NDArray[np.float64], step_v: float, bits: int) -> NDArray[np.float32]:
    """Voltages rounded to ADC codes -2^(bits-1) ... 2^(bits-1) - 1 and scaled back to volts."""
    half = 2 ** (bits - 1)
    return (np.clip(np.rint(volts / step_v), -half, half - 1) * step_v).astype(np.float32)


def _add_transients(
    setup: ShotSetup,
    spans: list[tuple[float, float, SwitchPosition]],
    times: NDArray[np.float64],
    volts: NDArray[np.float64],
) -> None:
    """Add a decaying step that starts at every closing of the receive contact."""
    options = setup.options.switch
    level = np.array(options.transient_v)[:, None]
    closings = [a for a, _, position in spans if position is SwitchPosition.RECEIVE]
    for closed_s, next_s in pairwise([*closings, np.inf]):
        first, last = np.searchsorted(times, [closed_s, min(closed_s + 50 * options.transient_tau_s, next_s)])
        volts[:, first:last] += level * np.exp(-(times[first:last] - closed_s) / options.transient_tau_s)


def _add_interference(setup: ShotSetup, times: NDArray[np.float64], volts: NDArray[np.float64]) -> None:
    start_s = (setup.timeline.rx_start + setup.timeline.rx_samples / 2) / setup.timeline.clock.rate_hz
    volts[:, (times >= start_s) & (times < start_s + OVERLOAD_BURST_S)] += 2 * setup.options.lna.output_limit_v


def _add_clipping(setup: ShotSetup, times: NDArray[np.float64], volts: NDArray[np.float64]) -> None:
    start_s = (setup.timeline.rx_start + setup.timeline.rx_samples / 2) / setup.timeline.clock.rate_hz
    volts[:, (times >= start_s) & (times < start_s + CLIPPING_S)] = 2 * setup.options.card.input_full_scale_v


def _limit(setup: ShotSetup, times: NDArray[np.float64], volts: NDArray[np.float64]) -> float | None:
    """Limit the LNA's output in place; return when the LNA first reported overload, s."""
    over = np.flatnonzero(np.any(np.abs(volts) >= setup.options.lna.overload_v, axis=0))
    np.clip(volts, -setup.options.lna.output_limit_v, setup.options.lna.output_limit_v, out=volts)
    return float(times[over[0]]) if over.size else None
