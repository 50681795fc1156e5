"""Angle, velocity and acceleration of a record, for peers that need derivatives."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.signal import butter, savgol_filter, sosfiltfilt

from platform_daemon.estimation.numerics.arrays import Array
from tests.benchmarks.peers.datasets import Record

_ORDER = 5
_ANGLE_WINDOW = 0.1  # of a period: 79 samples at 1 kHz and 1.27 Hz
_DMDT_WINDOW = 0.3
_LOW_PASS_HZ, _HIGH_PASS_HZ = 2500.0, 40.0
_EDGE_S = 0.03  # where the filters of dm/dt have not settled


@dataclass(frozen=True)
class States:
    """All (n,); w: angular frequency of the record's strongest line, rad/s."""

    time_s: Array
    phi: Array
    v: Array
    a: Array
    w: float

    @property
    def rate_hz(self) -> float:
        return (self.time_s.size - 1) / float(self.time_s[-1] - self.time_s[0])


def strongest_line(samples: Array, rate_hz: float) -> float:
    """Angular frequency, rad/s."""
    window = np.hanning(samples.size)
    spectrum = np.abs(np.fft.rfft((samples - samples.mean()) * window, 8 * samples.size))
    return 2.0 * math.pi * float(np.argmax(spectrum)) * rate_hz / (8 * samples.size)


def states_of(record: Record) -> States:
    """By Savitzky-Golay of order 5; of dm/dt by the generous recipe: the peer is told R and m_r."""
    if record.quantity == "angle":
        return _derived(record.time_s, record.signal[0], _ANGLE_WINDOW)
    assert record.rotation is not None
    rate = record.rate_hz
    local = record.rotation.T @ record.signal
    low = butter(4, _LOW_PASS_HZ, "lowpass", fs=rate, output="sos")
    high = butter(2, _HIGH_PASS_HZ, "highpass", fs=rate, output="sos")
    dm_v = sosfiltfilt(low, local[1])
    m_v = sosfiltfilt(high, cumulative_trapezoid(dm_v, dx=1.0 / rate, initial=0))
    phi = np.arcsin(np.clip(m_v / record.moment_am2, -0.999, 0.999))
    edge = round(_EDGE_S * rate)
    inside = slice(edge, phi.size - edge)
    v = (dm_v / (record.moment_am2 * np.cos(phi)))[inside]
    derived = _derived(record.time_s[inside], phi[inside], _DMDT_WINDOW)
    size = _window(rate, derived.w, _DMDT_WINDOW)
    a = savgol_filter(v, size, _ORDER, deriv=1, delta=1.0 / rate)
    return States(derived.time_s, phi[inside], v, a, derived.w)


def _derived(time_s: Array, angle: Array, share: float) -> States:
    rate = (time_s.size - 1) / float(time_s[-1] - time_s[0])
    w = strongest_line(angle, rate)
    size = _window(rate, w, share)
    phi, v, a = (savgol_filter(angle, size, _ORDER, deriv=k, delta=1.0 / rate) for k in range(3))
    return States(time_s, phi, v, a, w)


def _window(rate_hz: float, w: float, share: float) -> int:
    """Odd, and more than the order."""
    return max(2 * round(0.5 * share * 2.0 * math.pi / w * rate_hz) + 1, _ORDER + 4)
