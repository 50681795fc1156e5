"""From a request to the work of its procedure."""

from __future__ import annotations

from platform_daemon.schemas import AnyProcedureRequest, SequencePatch, TuneRequest

from ..engine import Engine
from ..planning import untuned_sequence
from .conductor import ProcedureFiles, ProcedureWork
from .engine_steps import EngineSteps
from .procedure import Procedure
from .sweep import Sweep
from .tune import Tune, TuneBench


def plan_procedure(engine: Engine, request: AnyProcedureRequest, files: ProcedureFiles) -> ProcedureWork:
    """The work of a procedure for `Engine.conduct`, every known step checked; nothing moves.  Raises InputError."""
    steps = EngineSteps(engine)
    return ProcedureWork(_procedure(engine, request, steps), steps, files)


def _procedure(engine: Engine, request: AnyProcedureRequest, steps: EngineSteps) -> Procedure:
    if isinstance(request, TuneRequest):
        specimen, _ = engine.catalogue.resonators.load(request.acquisition.resonator)
        sequence = untuned_sequence(request.acquisition, specimen, engine.catalogue)
        limits, presets = engine.side.limits, engine.catalogue.tuned
        plain = request.acquisition.model_copy(update={"sequence": SequencePatch()})
        preset = untuned_sequence(plain, specimen, engine.catalogue)
        return Tune(request, TuneBench(specimen, preset, sequence, limits, steps.check, presets))
    return Sweep(request)
