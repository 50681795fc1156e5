"""Contracts of what calibrates a platform: a small dipole of known moment, and a probe of known sensitivity.

Each takes the place that the rotor has in a measurement, one at a time, and both are removed before a series.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from drivers.identity import Identity


@dataclass(frozen=True)
class FrequencyStandard:
    """A generator of known frequency: frequency_hz; relative_std: of it; source: where that is known from."""

    frequency_hz: float
    relative_std: float
    source: str


class ReferenceDipole(Protocol):
    """A small coil of known turns times area, fed by an output of the I/O card that no amplifier hangs on.

    The card plays on that output while the receiver is connected and the amplifier is disabled, so the moment is known
    in amplitude and in phase against the samples, and power and receiver stay apart.
    """

    def identity(self) -> Identity:
        """Identity of the dipole."""

    def output(self) -> int:
        """The card's output that feeds it."""

    def moment_per_volt_am2(self, frequency_hz: float) -> complex:
        """Moment per volt at the output, A m^2/V: phasors of the same sine."""

    def relative_std(self) -> float:
        """Standard deviation of the moment, relative: the same for every frequency and direction."""

    def direction_std_rad(self) -> float | None:
        """Standard uncertainty of its direction about each of the two axes across, rad; None: nobody knows."""

    def standard(self) -> FrequencyStandard | None:
        """What it can be fed from in place of the card, to compare clocks; None: nothing."""

    def feed_from_standard(self) -> bool:
        """Feed it from the standard, until it is taken out.  False: an operator has to do it."""

    def turn(self, axis: str) -> bool:
        """Bring it to the rotor's place along world axis x, y or z.  False: an operator has to do it."""

    def remove(self) -> None:
        """Take it out.  Harmless if it is not there; of an operator's dipole: nothing."""


class FieldProbe(Protocol):
    """A three-axis field sensor that records on the card's clock."""

    def identity(self) -> Identity:
        """Identity of the probe."""

    def relative_std(self) -> float:
        """Standard deviation of its sensitivity, relative."""

    def put(self) -> bool:
        """Bring it to the rotor's place.  False: an operator has to do it."""

    def field_t(self) -> NDArray[np.float64]:
        """The field during the last shot, sample k at k / rate after the trigger: (3, n) float64, T, world axes.

        Raises DeviceError if it has not recorded the shot."""

    def remove(self) -> None:
        """Take it out.  Harmless if it is not there."""
