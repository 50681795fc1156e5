"""From the requested field at the rotor to the sine on each DAC output."""

from __future__ import annotations

import cmath
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.calibration import TransmitChannel
from drivers.errors import SequenceRejected

NEGLIGIBLE_SHARE = 1e-9  # of the largest coil current: far below one step of any DAC


@dataclass(frozen=True)
class ChannelDrive:
    """One coil's share: loop current amplitude A (signed, phase 0), amplifier and DAC amplitudes V, DAC phase rad."""

    channel: TransmitChannel
    current_a: float
    amplifier_v: float
    dac_v: float
    phase_rad: float


def drives_for_field(
    field_t: NDArray[np.float64], frequency_hz: float, channels: Sequence[TransmitChannel]
) -> tuple[ChannelDrive, ...]:
    """Drives that make the field `field_t * sin(2 pi f t)` at the rotor, (3,) T in world axes.

    The loop is resistance and inductance in series, so a voltage advanced by the angle of its impedance gives a current
    that starts at zero with the steady-state slope: no transient, a zero-phase field from the first sample.  Raises
    SequenceRejected if the coils cannot make a field in that direction.
    """
    per_ampere = np.stack([c.field_per_ampere_t for c in channels], axis=1)
    currents = np.linalg.pinv(per_ampere) @ field_t
    if not np.allclose(per_ampere @ currents, field_t, rtol=0, atol=1e-9 * float(np.linalg.norm(field_t))):
        raise SequenceRejected(
            "the coils cannot make a field in this direction",
            where="sequence.axis",
            remedy=f"use a direction inside the span of the coils {', '.join(c.axis for c in channels)}",
        )
    floor = NEGLIGIBLE_SHARE * float(np.max(np.abs(currents)))
    pairs = zip(channels, currents.tolist(), strict=True)
    return tuple(_drive(c, i, frequency_hz) for c, i in pairs if abs(i) > floor)


def _drive(channel: TransmitChannel, current_a: float, frequency_hz: float) -> ChannelDrive:
    impedance = channel.impedance_ohm(frequency_hz)
    amplifier_v = abs(current_a) * abs(impedance)
    phase = cmath.phase(impedance) + (np.pi if current_a < 0 else 0.0)
    return ChannelDrive(channel, current_a, amplifier_v, amplifier_v / channel.amplifier_gain, phase)
