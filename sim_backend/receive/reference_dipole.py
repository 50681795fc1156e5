"""The reference dipole: a small coil that the card feeds, for calibrating the receive side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim_backend.options import DipoleTable


@dataclass(frozen=True)
class Dipole:
    """The reference dipole in one orientation: its table, and its direction, a unit vector (3,) in world axes;
    by_standard: its table's generator feeds it, not the card."""

    table: DipoleTable
    direction: NDArray[np.float64]
    by_standard: bool = False

    def moment_per_volt_am2(self, frequency_hz: float) -> complex:
        """Moment per volt at the card's output, A m^2/V: turns times area times the current of an R-L loop."""
        loop_ohm = complex(self.table.resistance_ohm, 2 * np.pi * frequency_hz * self.table.inductance_h)
        return self.table.turns_area_m2 / loop_ohm
