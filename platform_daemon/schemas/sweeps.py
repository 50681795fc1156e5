"""A sweep: what is asked for."""

from __future__ import annotations

import math
from decimal import Decimal
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, model_validator
from typing_extensions import TypeAliasType

from .base import Finite, Given, Request
from .procedure_requests import ProcedureRequest

MOST_STEPS = 1000
"""Of one sweep, or ramp."""
Comparison = TypeAliasType("Comparison", Literal[">", "<", ">=", "<="])
_Key = Annotated[str, Field(min_length=1, max_length=100)]
_Number = Annotated[int, Field(ge=-(10**12), le=10**12)] | Finite
_Value = _Number | Annotated[str, Field(max_length=100)] | Annotated[tuple[Finite, ...], Field(strict=False)]


class SweepAxis(Request):
    """One key of the acquisition and the values that it takes: a range (`start`, `stop`, `step`), or `values`."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"key": "field_ut", "start": 50, "stop": 300, "step": 50}]}
    )

    key: _Key
    """A key of the acquisition, nested by dots, as sequence.field_t; keys of `sequence` also by their own name, and
    fields, times and frequencies also in people's units: field_ut, rx_ms, f_tx_khz."""
    start: Given[_Number] = None
    """First value, in the unit that the key names."""
    stop: Given[_Number] = None
    """Last value, which is taken too if whole steps lead there."""
    step: Given[_Number] = None
    """From each value to the next one; negative: downwards."""
    values: Given[Annotated[tuple[_Value, ...], Field(strict=False, min_length=1, max_length=MOST_STEPS)]] = None
    """The values one by one, in the place of a range."""

    @model_validator(mode="after")
    def _range_or_values(self) -> SweepAxis:
        span = (self.start, self.stop, self.step)
        if (self.values is None) == all(part is None for part in span):
            raise ValueError("give either start, stop and step, or values")
        if self.values is None:
            if any(part is None for part in span):
                raise ValueError("a range needs start, stop and step")
            _count_of(*span)  # type: ignore[arg-type]
        return self

    @property
    def points(self) -> tuple[Any, ...]:
        """Every value, in order; of a range without rounding errors."""
        if self.values is not None:
            return self.values
        assert self.start is not None
        assert self.stop is not None
        assert self.step is not None
        first, step = Decimal(str(self.start)), Decimal(str(self.step))
        whole = all(isinstance(part, int) for part in (self.start, self.step))
        count = _count_of(self.start, self.stop, self.step)
        return tuple((int if whole else float)(first + k * step) for k in range(count))


def _count_of(start: float, stop: float, step: float) -> int:
    if step == 0:
        raise ValueError("a step of 0 leads nowhere: give the distance between two values")
    if (stop - start) * math.copysign(1.0, step) < 0:
        raise ValueError(f"steps of {step:g} do not lead from {start:g} to {stop:g}: change the sign of step")
    # From the values as they are written: as binary numbers 0.1, 0.2, 0.3 are not evenly spaced.
    steps = (Decimal(str(stop)) - Decimal(str(start))) / Decimal(str(step))
    if steps >= MOST_STEPS:
        raise ValueError(f"more than {MOST_STEPS} steps: make the step larger")
    return int(steps) + 1


class StopRule(Request):
    """Ends a procedure after the first step whose result is so."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"result": "phi_max_deg", "comparison": ">", "value": 40}]}
    )

    result: _Key
    """A result of the step, as phi_max_rad or chi2_per_dof; angles in degrees too, as phi_max_deg."""
    comparison: Comparison
    """How the step's median compares with `value`."""
    value: _Number
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
