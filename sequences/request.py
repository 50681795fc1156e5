"""What a user asks for: one measurement sequence in physical units (paper, tab:measurement_parameter)."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, field_validator

Finite = Annotated[float, Field(allow_inf_nan=False)]
Axis = Literal["x", "y", "z"]


class SequenceRequest(BaseModel):
    """One shot and how often to repeat it.

    f_tx_hz: excitation frequency, Hz; tx_periods: whole periods in the TX window; field_t: amplitude of the sine at
    the rotor, T; axis: "x", "y", "z" or a direction vector in world axes (normalised here); switch_s: from the end of
    TX to the first RX sample, s; guard_samples: samples between amplifier off and receiver connect; rx_s: RX window, s;
    repetitions: excited shots; blank_shots: shots without excitation before them; pause_s: wait between shots, s.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    f_tx_hz: Annotated[float, Field(ge=0.01, le=20e3, allow_inf_nan=False)]
    tx_periods: Annotated[int, Field(ge=1, le=100_000)]
    field_t: Annotated[float, Field(gt=0, le=1.0, allow_inf_nan=False)]
    axis: Axis | Annotated[tuple[Finite, Finite, Finite], Field(strict=False)] = "x"
    switch_s: Annotated[float, Field(gt=0, le=10.0, allow_inf_nan=False)]
    guard_samples: Annotated[int, Field(ge=1, le=100_000)]
    rx_s: Annotated[float, Field(gt=0, le=600.0, allow_inf_nan=False)]
    repetitions: Annotated[int, Field(ge=0, le=1_000_000)] = 1
    blank_shots: Annotated[int, Field(ge=0, le=10_000)] = 0
    pause_s: Annotated[float, Field(ge=0, le=86_400.0, allow_inf_nan=False)] = 0.0

    @field_validator("axis")
    @classmethod
    def _needs_a_direction(cls, axis: Axis | tuple[float, float, float]) -> Axis | tuple[float, float, float]:
        if not isinstance(axis, str) and not 1e-6 < np.max(np.abs(axis)) < 1e6:
            raise ValueError("the axis vector must not be zero, tiny or huge")
        return axis

    def direction(self) -> NDArray[np.float64]:
        """Unit vector of the excitation field, (3,) in world axes."""
        if isinstance(self.axis, str):
            return np.eye(3)["xyz".index(self.axis)]
        vector = np.asarray(self.axis, dtype=float)
        return vector / np.linalg.norm(vector)
