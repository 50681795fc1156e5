"""The request: one measurement sequence in physical units (paper, tab:measurement_parameter)."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

Finite = Annotated[float, Field(allow_inf_nan=False)]
Axis = Literal["x", "y", "z"]
Waveform = Literal["sine", "rectangle"]
PhasePlan = Literal["none", "model", "last_fit"]


class SequenceRequest(BaseModel):
    """One shot and how often to repeat it.

    f_tx_hz: excitation frequency, Hz; tx_periods: whole periods in the TX window; field_t: amplitude of the sine at
    the rotor, T; axis: "x", "y", "z" or a direction vector in world axes (normalised here); switch_s: from the end
    of TX to the first RX sample, s; guard_samples: samples between amplifier off and receiver connect; rx_s: RX
    window, s; waveform: shape of a half period; duty: share of it in which a rectangle is not zero; chirp_hz:
    change of the frequency from the start of TX to its end, Hz; phase_rad: of the field at the start of TX;
    phase_plan: "model": the model of the resonator is integrated forward and the field follows its velocity,
    "last_fit": as the last fit of the series says; plan_parameters: values of the model by public name in the place
    of the resonator's own; f_nat_tolerance: the plan is the best in the worst case of f_nat off by so much,
    relative; repetitions: excited shots; blank_shots: shots without excitation before them; pause_s: wait between
    shots, s.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    f_tx_hz: Annotated[float, Field(ge=0.01, le=20e3, allow_inf_nan=False)]
    tx_periods: Annotated[int, Field(ge=1, le=100_000)]
    field_t: Annotated[float, Field(gt=0, le=1.0, allow_inf_nan=False)]
    axis: Axis | Annotated[tuple[Finite, Finite, Finite], Field(strict=False)] = "x"
    switch_s: Annotated[float, Field(gt=0, le=10.0, allow_inf_nan=False)]
    guard_samples: Annotated[int, Field(ge=1, le=100_000)]
    rx_s: Annotated[float, Field(gt=0, le=600.0, allow_inf_nan=False)]
    waveform: Waveform = "sine"
    duty: Annotated[float, Field(ge=0.05, le=1, allow_inf_nan=False)] = 1.0
    chirp_hz: Annotated[float, Field(ge=-20e3, le=20e3, allow_inf_nan=False)] = 0.0
    phase_rad: Annotated[float, Field(ge=-7.0, le=7.0, allow_inf_nan=False)] = 0.0
    phase_plan: PhasePlan = "none"
    plan_parameters: Annotated[dict[str, Finite], Field(max_length=50)] = Field(default_factory=dict)
    f_nat_tolerance: Annotated[float, Field(ge=0, le=0.02, allow_inf_nan=False)] = 0.0
    repetitions: Annotated[int, Field(ge=0, le=1_000_000)] = 1
    blank_shots: Annotated[int, Field(ge=0, le=10_000)] = 0
    pause_s: Annotated[float, Field(ge=0, le=86_400.0, allow_inf_nan=False)] = 0.0

    @field_validator("axis")
    @classmethod
    def _needs_a_direction(cls, axis: Axis | tuple[float, float, float]) -> Axis | tuple[float, float, float]:
        if not isinstance(axis, str) and not 1e-6 < np.max(np.abs(axis)) < 1e6:
            raise ValueError("the axis vector must not be zero, tiny or huge")
        return axis

    @model_validator(mode="after")
    def _keys_of_the_drive_agree(self) -> SequenceRequest:
        if self.waveform == "sine" and self.duty != 1.0:
            raise ValueError("a sine has no duty: ask for the waveform rectangle, or leave duty out")
        if self.phase_plan != "none" and (self.chirp_hz or self.phase_rad):
            raise ValueError("a planned phase follows the rotor: leave chirp_hz and phase_rad out")
        if self.phase_plan == "none" and (self.plan_parameters or self.f_nat_tolerance):
            raise ValueError("plan_parameters and f_nat_tolerance belong to a phase_plan: ask for model or last_fit")
        if self.f_tx_hz + min(self.chirp_hz, 0.0) < 0.5 * self.f_tx_hz:
            raise ValueError("the chirp would end below half the frequency at which it begins")
        return self

    @property
    def is_plain(self) -> bool:
        """One sine of constant frequency over the whole window, which every card can play."""
        return self.waveform == "sine" and not self.chirp_hz and self.phase_plan == "none"

    def direction(self) -> NDArray[np.float64]:
        """Unit vector of the excitation field, (3,) in world axes."""
        if isinstance(self.axis, str):
            return np.eye(3)["xyz".index(self.axis)]
        vector = np.asarray(self.axis, dtype=float)
        return vector / np.linalg.norm(vector)
