"""Tune: what is asked for, and what it finds."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from .base import Schema
from .procedure_requests import ProcedureRequest
from .requests import FieldTesla


class TuneRequest(ProcedureRequest):
    """Tune: find the resonator's frequency, and how it is measured best."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"kind": "tune", "acquisition": {"resonator": "jewel"}, "max_field_t": 3e-4}]}
    )

    kind: Literal["tune"]
    """Tune."""
    max_field_t: FieldTesla | None = None
    """Highest field that it may use, T; null: the resonator's own limit, or that of the platform."""


class TuneOutcome(Schema):
    """What tune has found so far."""

    kind: Literal["tune"]
    """Tune."""
    f_nat_hz: Annotated[float, Field(gt=0)] | None
    """Natural frequency of small swings, Hz; null: nothing has rung yet."""
