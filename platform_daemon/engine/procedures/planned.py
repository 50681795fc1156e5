"""From a request to the work of its procedure."""

from __future__ import annotations

from platform_daemon import analysis
from platform_daemon.schemas import CharacteriseRequest, ProcedureRequest

from ..engine import Engine
from ..work.characterisation import CharacterisationFiles
from .characterise import Characterise, CharacteriseConclusion
from .conductor import ProcedureFiles, ProcedureWork
from .engine_steps import EngineSteps
from .sweep import Sweep


def plan_procedure(
    engine: Engine, request: ProcedureRequest, files: ProcedureFiles, tables: CharacterisationFiles | None = None
) -> ProcedureWork:
    """The work of a procedure for `Engine.conduct`, every known step checked; nothing moves.  Raises InputError.

    tables: where a characterisation keeps its report and page; None: in the job's result alone.
    """
    steps = EngineSteps(engine)
    if isinstance(request, CharacteriseRequest):
        model = engine.plan(request.acquisition).model
        analysis.check_held_in_n50(model, request.held_in_n50)
        conclusion = CharacteriseConclusion(request, model, tables)
        return ProcedureWork(Characterise(request), steps, files, conclusion=conclusion)
    return ProcedureWork(Sweep(request), steps, files)
