"""The calibration of a platform: receive sensitivity with its frequency response, and the transmit side."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from drivers.errors import ConfigError


@dataclass(frozen=True)
class ReceiverEffect:
    """What the receive chain does beyond its calibration, as an adopted model knows it; the daemon corrects for it.

    Attributes:
        id: of the effect; strength: in its unit.
        axis: x, y or z: the one channel it acts on; None: all.
        source, target: of crosstalk.
        even: it acts on the even (True) or the odd (False) harmonics of `fundamental_hz` only; None: on everything.
    """

    id: str
    strength: float
    axis: str | None = None
    source: str | None = None
    target: str | None = None
    even: bool | None = None
    fundamental_hz: float | None = None


@dataclass(frozen=True)
class TransmitChannel:
    """Transmit side of one coil axis: from the DAC output to the field at the rotor.

    output: index of the DAC output; amplifier_gain: V/V; resistance_ohm and inductance_h: of the whole loop, amplifier
    output impedance included; field_per_ampere_t: (3,) T/A at the rotor's position in world axes.
    """

    axis: str
    output: int
    amplifier_gain: float
    amplifier_limit_v: float
    resistance_ohm: float
    inductance_h: float
    field_per_ampere_t: NDArray[np.float64]

    def impedance_ohm(self, frequency_hz: float) -> complex:
        """Complex loop impedance at a frequency."""
        return complex(self.resistance_ohm, 2 * np.pi * frequency_hz * self.inductance_h)


@dataclass(frozen=True, eq=False)
class TransmitCalibration:
    """Measured transmit side: field at the rotor per volt at the DAC, and what follows for each coil.

    axes: names of the coils; frequency_hz: (k,); field_per_volt: (coil, 3, k) complex, T/V, and its standard deviation
    per real component, both of the same shape; field_per_ampere_t: (coil, 3) and inductance_h: (coil,), under the
    declared amplifier gains and resistances; valid_hz, valid_c, temperature_c: as in ReceiveCalibration.
    """

    axes: tuple[str, ...]
    identifier: str
    date: str
    frequency_hz: NDArray[np.float64]
    field_per_volt: NDArray[np.complex128]
    field_per_volt_std: NDArray[np.float64]
    field_per_ampere_t: NDArray[np.float64]
    inductance_h: NDArray[np.float64]
    valid_hz: tuple[float, float] | None = None
    valid_c: tuple[float, float] | None = None
    temperature_c: float | None = None

    def applied(self, channels: tuple[TransmitChannel, ...]) -> tuple[TransmitChannel, ...]:
        """The channels with measured field and inductance in place of the declared ones.  Raises ConfigError."""
        if tuple(c.axis for c in channels) != self.axes:
            raise ConfigError(
                f"the transmit calibration is for the coils {', '.join(self.axes)}",
                where="transmit_calibration",
                why=f"it is {self.identifier!r}",
                remedy="name a calibration of this platform",
            )
        rows = zip(channels, self.field_per_ampere_t, self.inductance_h.tolist(), strict=True)
        return tuple(replace(c, field_per_ampere_t=field_t, inductance_h=henry) for c, field_t, henry in rows)


def channel_names(channels: int) -> tuple[str, ...]:
    """Of receive channels: their axes if there are three, else numbers."""
    return ("x", "y", "z") if channels == 3 else tuple(map(str, range(channels)))


def gain_of(channel: str) -> str:
    """Name of the influence, as budgets print it."""
    return f"gain of channel {channel}"


def phase_of(channel: str) -> str:
    """Name of the influence, as budgets print it."""
    return f"phase of channel {channel}"


def angle_of(channel: str, axis: int) -> str:
    """Name of the influence, as budgets print it: the coil of a channel turned towards a world axis, 0 to 2."""
    return f"orthogonality of coil {channel} and {'xyz'[axis]}"


def turned_towards(sensitivity: NDArray[np.float64]) -> list[tuple[int, int]]:
    """Channel and world axis of every angle between them: all but the axis that a channel hears best."""
    own = np.argmax(np.abs(sensitivity), axis=1)
    return [(c, axis) for c in range(len(own)) for axis in range(3) if axis != own[c]]


@dataclass(frozen=True)
class MeasuredInfluence:
    """How well a calibration knows an influence on later results, by its own measurement.

    Attributes:
        name: as budgets print it, "gain of channel x".
        u: standard uncertainty, relative or rad.
        kind: "A" of repeated observations, "B" of anything else; dof: degrees of freedom of u, None: infinitely many.
        source: how it was found, in words.
    """

    name: str
    u: float
    kind: Literal["A", "B"]
    dof: float | None
    source: str


@dataclass(frozen=True, eq=False)
class ReceiveCalibration:
    """Receive side, paper eq:u(t,p,R): u = -P dm/dt.

    sensitivity: (channel, 3) float64, V/(A m^2/s) = T/A, columns world x, y, z, all gains up to the ADC input included
    (at the LNA gain `lna_gain`, V/V); identifier and date (ISO 8601) name this calibration in every recording made with
    it; frequency_hz: (k,) rising, and frequency_response: (channel, k) complex128 that multiplies the sensitivity, both
    None: flat. sensitivity_std: (channel, 3), T/A; p_std: (channel, 3, k), T/A, of P at each frequency, noise alone;
    relative_std: of all of P together, the reference's own; valid_hz, valid_c: frequencies Hz and temperatures deg C
    between which it holds; temperature_c: at which it was made; transmit: the measured transmit side;
    influences: how well it knows gains, phases and angles of the channels. None: not said, as in many recordings from
    elsewhere.
    receiver: what an adopted model corrects in addition; never part of a file.
    """

    sensitivity: NDArray[np.float64]
    identifier: str | None = None
    date: str | None = None
    lna_gain: float | None = None
    frequency_hz: NDArray[np.float64] | None = None
    frequency_response: NDArray[np.complex128] | None = None
    sensitivity_std: NDArray[np.float64] | None = None
    p_std: NDArray[np.float64] | None = None
    relative_std: float | None = None
    valid_hz: tuple[float, float] | None = None
    valid_c: tuple[float, float] | None = None
    temperature_c: float | None = None
    transmit: TransmitCalibration | None = None
    influences: tuple[MeasuredInfluence, ...] = ()
    receiver: tuple[ReceiverEffect, ...] = ()
