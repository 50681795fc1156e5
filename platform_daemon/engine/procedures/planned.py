"""From a request to the work of its procedure."""

from __future__ import annotations

from drivers.errors import InputError
from platform_daemon import analysis
from platform_daemon.schemas import AnyProcedureRequest, CharacteriseRequest, SweepRequest

from ..engine import Engine
from ..work.characterisation import CharacterisationFiles
from .characterise import Characterise, CharacteriseConclusion
from .conductor import ProcedureFiles, ProcedureWork
from .engine_steps import EngineSteps
from .procedure import Conclusion, Procedure
from .sweep import Sweep


def plan_procedure(
    engine: Engine, request: AnyProcedureRequest, files: ProcedureFiles, tables: CharacterisationFiles | None = None
) -> ProcedureWork:
    """The work of a procedure for `Engine.conduct`, every known step checked; nothing moves.  Raises InputError.

    tables: where a characterisation keeps its report and page; None: in the job's result alone.
    """
    conclusion = _conclusion(engine, request, tables)
    return ProcedureWork(_procedure(request), EngineSteps(engine), files, conclusion=conclusion)


def _procedure(request: AnyProcedureRequest) -> Procedure:
    match request:
        case SweepRequest():
            return Sweep(request)
        case CharacteriseRequest():
            return Characterise(request)
    remedy = "ask for a sweep, or for a characterisation"
    raise InputError(f"no procedure {request.kind!r} can be made", where="kind", remedy=remedy)


def _conclusion(
    engine: Engine, request: AnyProcedureRequest, tables: CharacterisationFiles | None
) -> Conclusion | None:
    if not isinstance(request, CharacteriseRequest):
        return None
    model = engine.plan(request.acquisition).model
    analysis.check_held_in_n50(model, request.held_in_n50)
    return CharacteriseConclusion(request, model, tables)
