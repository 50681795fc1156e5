"""Request that all procedures share."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import AfterValidator, Field

from platform_daemon.core.schemas.base import QueuedRequest, Schema
from platform_daemon.core.schemas.requests import AcquisitionRequest


def _of_every_step(acquisition: AcquisitionRequest) -> AcquisitionRequest:
    if acquisition.shot_changes is not None:
        raise ValueError("the shots of a step are alike, for some may be repeated: sweep the keys of shot_changes")
    if acquisition.priority:
        raise ValueError("its steps have the priority of the procedure: give `priority` next to `acquisition`")
    return acquisition


class Outcome(Schema):
    """What a procedure finds apart from the results of its steps."""

    makes_page: ClassVar[bool] = False
    """True if the procedure keeps a page of it."""

    kind: str
    """Which procedure."""


class ProcedureRequest(QueuedRequest):
    """A procedure of any kind."""

    kind: str
    """Which procedure."""
    acquisition: Annotated[AcquisitionRequest, AfterValidator(_of_every_step)]
    """What every step has in common; `shots` and `blank_shots` are per step."""
    longest_pause_s: Annotated[float, Field(gt=0, le=604_800, allow_inf_nan=False)] = 28_800.0
    """A pause that lasts longer ends it, s: it holds up those that wait, and a change of calibration."""

    @property
    def mounted_resonator(self) -> str | None:
        """See QueuedRequest."""
        return self.acquisition.resonator
