"""A key of a series and its values."""

from __future__ import annotations

import math
from decimal import Decimal
from typing import Annotated, Any

from pydantic import ConfigDict, Field, model_validator

from platform_daemon.core.schemas.base import Finite, Given, Request

MOST_STEPS = 1000
"""Of one sweep, or ramp."""
SweptKey = Annotated[str, Field(min_length=1, max_length=100)]
SweptNumber = Annotated[int, Field(ge=-(10**12), le=10**12)] | Finite
SweptPoint = SweptNumber | Annotated[str, Field(max_length=100)] | Annotated[tuple[Finite, ...], Field(strict=False)]


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


class SweepAxis(Request):
    """One key of the acquisition and the values that it takes: a range (`start`, `stop`, `step`), or `values`."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"key": "field_ut", "start": 50, "stop": 300, "step": 50}]}
    )

    key: SweptKey
    """A key of the acquisition, nested by dots, as sequence.field_t; keys of `sequence` also by their own name, and
    fields, times and frequencies also in people's units: field_ut, rx_ms, f_tx_khz."""
    start: Given[SweptNumber] = None
    """First value, in the unit that the key names."""
    stop: Given[SweptNumber] = None
    """Last value, which is taken too if whole steps lead there."""
    step: Given[SweptNumber] = None
    """From each value to the next one; negative: downwards."""
    values: Given[Annotated[tuple[SweptPoint, ...], Field(strict=False, min_length=1, max_length=MOST_STEPS)]] = None
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
