"""What every procedure is asked for."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from .base import Request
from .requests import AcquisitionRequest


class ProcedureRequest(Request):
    """A procedure of any kind."""

    kind: str
    """Which procedure."""
    acquisition: AcquisitionRequest
    """What every step has in common; `shots` and `blank_shots` are per step."""
    longest_pause_s: Annotated[float, Field(gt=0, le=604_800, allow_inf_nan=False)] = 28_800.0
    """A pause that lasts longer ends it, s: it holds up those that wait, and a change of calibration."""
