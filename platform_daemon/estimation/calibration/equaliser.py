"""A short filter that undoes the receive chain where the signal is, and leaves the rest alone.

In the signal band it realises 1/H; above, log 1/H is faded out smoothly, so the filter becomes 1 and white noise
stays white there. Smoothness keeps the impulse response short; only as many samples as it reaches are lost at the
edges. Time zero does not move: a delay in H is undone, not shifted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import erfc

from platform_daemon.estimation.numerics.arrays import Array, ComplexArray
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.calibration


@dataclass(frozen=True)
class Equaliser:
    """Taps of an odd-length filter per channel, centred on time 0.

    Attributes:
        taps: (channels, 2 reach + 1); taps[:, reach] acts on the sample itself.
        reach: samples lost at either end.
        notes: what had to be assumed about H.
    """

    taps: Array
    reach: int
    notes: tuple[str, ...]


def design_equaliser(frequency_hz: Array, response: ComplexArray, sampling_rate_hz: float) -> Equaliser:
    """Filter realising 1/H in 0 .. 8 kHz (or a sixth of the rate), fading to 1 over the next octave.

    Args:
        frequency_hz: (k,) rising grid of H.
        response: H, complex (channels, k), finite and non-zero.
        sampling_rate_hz: samples per second.
    """
    band = min(LIMITS.band_hz, sampling_rate_hz / LIMITS.band_rate_divisor)
    grid = np.linspace(0.0, 0.5 * sampling_rate_hz, LIMITS.equaliser_grid // 2 + 1)
    fade = _fade(grid / band)
    log_inverse = np.stack([-_log_response(grid, frequency_hz, row) for row in response])
    wanted = np.exp(fade * log_inverse)
    impulse = np.fft.irfft(wanted, LIMITS.equaliser_grid, axis=1)
    centred = np.roll(impulse, LIMITS.equaliser_grid // 2, axis=1)
    reach = _reach(centred, wanted, (grid > LIMITS.lowest_hz) & (grid < band))
    middle = LIMITS.equaliser_grid // 2
    taps = centred[:, middle - reach : middle + reach + 1]
    return Equaliser(taps, reach, _notes(frequency_hz, band))


def equalise(volts: Array, equaliser: Equaliser) -> Array:
    """Filter every channel, (channels, n) in and out; the first and last `reach` samples are not meaningful."""
    from scipy.signal import fftconvolve  # here, because a fit of calibrated records can start without it

    return np.stack([fftconvolve(row, taps, mode="same") for row, taps in zip(volts, equaliser.taps, strict=True)])


def _log_response(grid: Array, frequency_hz: Array, row: ComplexArray) -> ComplexArray:
    """log H on the grid: splines of log magnitude and unwrapped phase, held outside the table.

    A real system has an odd phase: it goes through a multiple of pi at 0 Hz, so the table is continued to there.
    """
    from scipy.interpolate import CubicSpline  # here, because a fit of calibrated records can start without it

    magnitude = np.log(np.abs(row))
    phase = np.unwrap(np.angle(row))
    anchor = np.pi * np.round(phase[0] / np.pi)
    knots, phases, magnitudes = frequency_hz, phase, magnitude
    if knots[0] > 0.0:
        knots = np.concatenate([[0.0], knots])
        phases = np.concatenate([[anchor], phase])
        magnitudes = np.concatenate([[magnitude[0]], magnitude])
    # Mirroring the table makes magnitude even and phase odd, so the splines know their symmetry at 0 Hz.
    both = np.concatenate([-knots[:0:-1], knots])
    even = CubicSpline(both, np.concatenate([magnitudes[:0:-1], magnitudes]))
    odd = CubicSpline(both, np.concatenate([anchor - (phases[:0:-1] - anchor), phases]))
    inside = np.minimum(grid, knots[-1])
    return np.asarray(even(inside) + 1j * odd(inside))


def _fade(x: Array) -> Array:
    """Gaussian-smooth step from 1 (x <= 1, to 1e-6) to 0 (x >= 2): the shortest impulse response for its slope."""
    return np.asarray(0.5 * erfc((x - LIMITS.fade_middle) / LIMITS.fade_width))


def _reach(centred: Array, wanted: ComplexArray, in_band: np.ndarray) -> int:
    """Shortest reach whose truncated filter still is what was wanted in the signal band."""
    middle = centred.shape[1] // 2
    for reach in LIMITS.equaliser_reaches:
        cut = np.zeros_like(centred)
        cut[:, middle - reach : middle + reach + 1] = centred[:, middle - reach : middle + reach + 1]
        realised = np.fft.rfft(np.roll(cut, -middle, axis=1), axis=1)
        if np.max(np.abs(realised - wanted)[:, in_band]) < LIMITS.equaliser_error:
            return reach
    return LIMITS.equaliser_reaches[-1]


def _notes(frequency_hz: Array, band: float) -> tuple[str, ...]:
    """Say where the table had to be continued."""
    notes = []
    if frequency_hz[0] > 0.0:
        notes.append(f"frequency response held constant in magnitude below {frequency_hz[0]:g} Hz")
    if frequency_hz[-1] < band:
        notes.append(f"frequency response held at its last value above {frequency_hz[-1]:g} Hz")
    return tuple(notes)
