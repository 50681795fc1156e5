"""A sweep: its request."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import ConfigDict, Field, model_validator
from typing_extensions import TypeAliasType

from platform_daemon.core.schemas.base import Request
from platform_daemon.core.schemas.sweep_axis import MOST_STEPS, SweepAxis, SweptKey, SweptNumber
from platform_daemon.features.procedures.request_schema import ProcedureRequest

Comparison = TypeAliasType("Comparison", Literal[">", "<", ">=", "<="])


class StopRule(Request):
    """Ends a procedure after the first step whose result is so."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"result": "phi_max_deg", "comparison": ">", "value": 40}]}
    )

    result: SweptKey
    """A result of the step, as phi_max_rad or chi2_per_dof; angles in degrees too, as phi_max_deg."""
    comparison: Comparison
    """How the step's median compares with `value`."""
    value: SweptNumber
    """In the unit that the result names."""

    def __str__(self) -> str:
        return f"{self.result} {self.comparison} {self.value:g}"


class SweepRequest(ProcedureRequest):
    """A sweep: the same acquisition again and again, each step with other values of some keys, in one recording."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "kind": "sweep",
                    "acquisition": {"resonator": "jewel", "shots": 2, "sequence": {"rx_s": 2.0}},
                    "over": [{"key": "field_ut", "start": 50, "stop": 300, "step": 50}],
                    "stop_when": {"result": "phi_max_deg", "comparison": ">", "value": 40},
                },
                {
                    "kind": "sweep",
                    "acquisition": {"resonator": "thread"},
                    "over": [{"key": "axis", "values": ["x", "y"]}, {"key": "sequence.tx_periods", "values": [8, 10]}],
                },
            ]
        }
    )

    kind: Literal["sweep"]
    """A sweep."""
    over: Annotated[tuple[SweepAxis, ...], Field(strict=False, min_length=1, max_length=5)]
    """Keys with their values; of several all combinations are made, the last one changes fastest."""
    stop_when: StopRule | None = None
    """Ends the sweep early; null: all steps are made."""

    @model_validator(mode="after")
    def _bounded(self) -> SweepRequest:
        if (steps := math.prod(len(axis.points) for axis in self.over)) > MOST_STEPS:
            raise ValueError(f"{steps} steps are more than {MOST_STEPS}: ask for fewer values")
        return self
