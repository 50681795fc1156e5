"""P from the answers to a reference dipole: u = -P dm/dt (eq:u(t,p,R)), per channel, axis and frequency."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.calibration
ROUNDS = LIMITS.split_rounds
CROSS_SHARE = LIMITS.cross_share


@dataclass(frozen=True)
class ReceiveResult:
    """What a calibration of the receive side found.

    frequency_hz: (k,); p: (channel, 3, k) complex, V/(A m^2/s) = T/A; std: the same shape, of the real and of the
    imaginary part, from noise; relative_std: of the dipole's moment, common to all.
    sensitivity: (channel, 3) and response: (channel, k), whose product is p as far as noise allows;
    chi2_per_dof: of that product against p; sensitivity_std: (channel, 3), the dipole's included.
    """

    frequency_hz: NDArray[np.float64]
    p: NDArray[np.complex128]
    std: NDArray[np.float64]
    relative_std: float
    sensitivity: NDArray[np.float64]
    sensitivity_std: NDArray[np.float64]
    response: NDArray[np.complex128]
    chi2_per_dof: float


def sensitivity_from(
    volts: NDArray[np.complex128], volts_std: NDArray[np.float64], moment_am2: complex, frequency_hz: float
) -> tuple[NDArray[np.complex128], NDArray[np.float64]]:
    """One column of P, (channel,) complex, and its standard deviation, from phasors of voltage and moment."""
    rate_of_change = 2j * np.pi * frequency_hz * moment_am2
    return -volts / rate_of_change, volts_std / abs(rate_of_change)


def receive_result(
    frequency_hz: NDArray[np.float64], p: NDArray[np.complex128], std: NDArray[np.float64], relative_std: float
) -> ReceiveResult:
    """Split P (channel, 3, k) into geometry, which is real, and each channel's frequency response.

    The response has magnitude 1 at the lowest frequency.  Least squares in turns, weighted with the noise of every
    frequency; where P is a product, as for any linear chain behind a small coil, chi2_per_dof is about 1.
    """
    split = [_split(p[c], std[c]) for c in range(len(p))]
    sensitivity = np.array([s for s, _, _ in split])
    noise = np.array([d for _, d, _ in split])
    response = np.array([h for _, _, h in split])
    left = np.abs(p - sensitivity[:, :, None] * response[:, None, :]) ** 2 / std**2
    channels, axes, k = p.shape
    dof = channels * (2 * axes * k - (axes + 2 * k - 1))
    return ReceiveResult(
        frequency_hz=frequency_hz,
        p=p,
        std=std,
        relative_std=relative_std,
        sensitivity=sensitivity,
        sensitivity_std=np.hypot(noise, relative_std * np.abs(sensitivity)),
        response=response,
        chi2_per_dof=float(left.sum() / dof),
    )


@dataclass(frozen=True)
class Repeatability:
    """Scatter of single shots about their mean: gain, relative, and phase, rad, (channel,); dof: of each."""

    gain: NDArray[np.float64]
    phase_rad: NDArray[np.float64]
    dof: int


def repeatability(heard: NDArray[np.complex128], sensitivity: NDArray[np.float64]) -> Repeatability | None:
    """How far one shot's gain and phase are off their mean, noise of its tone included; None: nothing was repeated.

    heard: (axis, k, repetition, channel), phasors of equal shots; sensitivity: (channel, 3).  Each channel is judged by
    the dipole along its own axis, all frequencies together (JCGM 100:2008, H.3.6: pooled estimate).
    """
    _, k, n, channels = heard.shape
    if n < 2:
        return None
    own = np.argmax(np.abs(sensitivity), axis=1)
    found = np.stack([heard[own[c], :, :, c] for c in range(channels)])
    off = found / found.mean(axis=2, keepdims=True) - 1.0
    dof = k * (n - 1)
    gain, phase = (np.sqrt(np.sum(part**2, axis=(1, 2)) / dof) for part in (off.real, off.imag))
    return Repeatability(gain, phase, dof)


def _split(
    p: NDArray[np.complex128], std: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.complex128]]:
    """One channel's P (3, k) as s (3,) real times h (k,) complex; s, its standard deviation, and h."""
    weight = 1 / std**2
    strongest = int(np.argmax(np.sum(np.abs(p) ** 2 * weight, axis=1)))
    s = np.eye(3)[strongest] * np.abs(p[strongest, 0]) * (1.0 if p[strongest, 0].real >= 0 else -1.0)
    h = np.ones(p.shape[1], dtype=np.complex128)
    for _ in range(ROUNDS):
        h = np.sum(weight * s[:, None] * p, axis=0) / np.sum(weight * s[:, None] ** 2, axis=0)
        s = np.sum(weight * (np.conj(h) * p).real, axis=1) / np.sum(weight * np.abs(h) ** 2, axis=1)
    scale = abs(h[0])
    s, h = s * scale, h / scale
    noise = 1 / np.sqrt(np.sum(weight * np.abs(h) ** 2, axis=1))
    of_scale = np.abs(s) / np.sqrt(np.sum((s / std[:, 0]) ** 2))  # the lowest frequency, itself measured, is the unit
    return s, np.hypot(noise, of_scale), h


def unlike_declared(found: NDArray[np.float64], declared: NDArray[np.float64]) -> list[str]:
    """What a new P (channel, 3) says of the wiring, against the declared one: sentences, [] if they are alike."""
    said = []
    names = "xyz"
    for c, (new, old) in enumerate(zip(found, declared, strict=True)):
        own, heard = int(np.argmax(np.abs(old))), int(np.argmax(np.abs(new)))
        if own != heard:
            said.append(f"receive channel {c} hears axis {names[heard]}, not {names[own]}: channels or coils exchanged")
        elif new[own] * old[own] < 0:
            said.append(f"the polarity of receive channel {c} is inverted")
        elif not 1 - CROSS_SHARE < new[own] / old[own] < 1 / (1 - CROSS_SHARE):
            said.append(f"the sensitivity of receive channel {c} is {new[own] / old[own]:.2f} of the declared one")
    return said
