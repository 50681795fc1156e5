"""From a request to the work of its procedure."""

from __future__ import annotations

from platform_daemon.schemas import SweepRequest

from ..engine import Engine
from .conductor import ProcedureFiles, ProcedureWork
from .engine_steps import EngineSteps
from .sweep import Sweep


def plan_procedure(engine: Engine, request: SweepRequest, files: ProcedureFiles) -> ProcedureWork:
    """The work of a procedure for `Engine.conduct`, every known step checked; nothing moves.  Raises InputError."""
    return ProcedureWork(Sweep(request), EngineSteps(engine), files)
