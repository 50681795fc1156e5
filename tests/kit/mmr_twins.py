"""Twins of the public recordings of magneto-mechanical resonators: coils of unknown sensitivity, read by a converter.

The motion is scipy's (tests/kit/pendulum.py), the file plain h5py; nothing of the simulator or of the fit is in them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from tests.kit.pendulum import half_cycles

BASE_HZ = 125e6
_NOISE, _FULL, _SIGNAL = 1.5, 2**15, 0.6  # counts, counts, share of them


@dataclass(frozen=True)
class Resonator:
    """phi'' = -w^2 sin phi - 2 lambda phi' - drag |phi'| phi' - dry sgn phi'; its converter's decimation.

    loss_per_s: lambda; drag_per_rad, dry_rad_per_s2: what no declared model of a thread has.
    """

    f_hz: float
    loss_per_s: float
    decimation: int
    seconds: float
    drag_per_rad: float = 0.0
    dry_rad_per_s2: float = 0.0

    @property
    def rate_hz(self) -> float:
        """Samples per second."""
        return BASE_HZ / self.decimation


LARGE = Resonator(f_hz=111.0, loss_per_s=0.9, decimation=12_500, seconds=1.6)
SMALL = Resonator(f_hz=811.0, loss_per_s=9.0, decimation=2_500, seconds=0.3)


def swung(rotor: Resonator, phi_max: float, phase: float) -> Any:
    """(phi, phi' in rad/s), (n,) each; phase: of the motion at the first sample, in radians of small swings."""
    w = 2.0 * math.pi * rotor.f_hz
    s = phase + w * np.arange(round(rotor.seconds * rotor.rate_hz)) / rotor.rate_hz
    loss, dry = 2.0 * rotor.loss_per_s / w, rotor.dry_rad_per_s2 / w**2

    def torque(phi: float, v: float, side: float, _: float) -> float:
        return -math.sin(phi) - loss * v - rotor.drag_per_rad * abs(v) * v - dry * side

    phi, v = half_cycles(torque, phi_max, s, 1e-12)
    return phi, w * v


def counted(rotor: Resonator, frames: int, channels: int, seed: int, phi_max: float = 0.9) -> Any:
    """Converter counts before rounding, (frame, channel, sample); every coil has its own a, b, every frame its start.

    volts_c = a_c d/dt(sin phi) + b_c d/dt(cos phi)
    """
    random = np.random.default_rng(seed)
    a, b = random.normal(size=(2, channels))
    out = []
    for _ in range(frames):
        phi, v = swung(rotor, phi_max * random.uniform(0.9, 1.1), random.uniform(0.0, 2.0 * math.pi))
        out.append(a[:, None] * v * np.cos(phi) - b[:, None] * v * np.sin(phi))
    volts = np.stack(out)
    volts *= _SIGNAL * _FULL / np.abs(volts).max()
    return volts + random.normal(0.0, _NOISE, volts.shape)


def write_twin(
    target: Path, rotor: Resonator, dtype: str = "<i2", *, frames: int = 3, channels: int = 3, seed: int = 1
) -> Path:
    """A file as the public ones are; floats are volts of a converter of +-1 V, unsigned counts have an offset."""
    counts, kind = counted(rotor, frames, channels, seed), np.dtype(dtype)
    rounded = np.round(counts)
    data = rounded / _FULL if kind.kind == "f" else rounded + (_FULL if kind.kind == "u" else 0)
    with h5py.File(target, "w") as file:
        file["data"] = data.astype(kind)
        file["sequence/baseFrequency"] = BASE_HZ
        file["sequence/decimation"] = rotor.decimation
    return target
