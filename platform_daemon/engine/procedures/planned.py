"""From a request to the work of its procedure."""

from __future__ import annotations

from drivers.errors import InputError
from platform_daemon.schemas import AnyProcedureRequest, SweepRequest

from ..engine import Engine
from .conductor import ProcedureFiles, ProcedureWork
from .engine_steps import EngineSteps
from .procedure import Procedure
from .sweep import Sweep


def plan_procedure(engine: Engine, request: AnyProcedureRequest, files: ProcedureFiles) -> ProcedureWork:
    """The work of a procedure for `Engine.conduct`, every known step checked; nothing moves.  Raises InputError."""
    return ProcedureWork(_procedure(request), EngineSteps(engine), files)


def _procedure(request: AnyProcedureRequest) -> Procedure:
    match request:
        case SweepRequest():
            return Sweep(request)
    raise InputError(f"no procedure {request.kind!r} can be made", where="kind", remedy="ask for a sweep")
