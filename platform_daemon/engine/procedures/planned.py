"""From a request to the work of its procedure."""

from __future__ import annotations

from drivers.errors import InputError
from drivers.specimen import Specimen
from platform_daemon.schemas import (
    AnyProcedureRequest,
    CharacteriseRequest,
    RampRequest,
    SequencePatch,
    SweepRequest,
    TuneRequest,
)

from ..computed import computed_surely
from ..engine import Engine
from ..planning import untuned_sequence
from ..work.characterisation import CharacterisationFiles
from .characterise import Characterise, CharacteriseConclusion, CheckHeld
from .computed_side_modes import ComputedSideModes
from .conductor import ProcedureFiles, ProcedureWork
from .engine_steps import EngineSteps
from .kept_limits import Keep, keep_beside, keep_in
from .procedure import OnlineFits, Procedure
from .ramp import Ramp, RampBasis
from .sweep import Sweep
from .tune import Tune, TuneBench


def plan_procedure(
    engine: Engine, request: AnyProcedureRequest, files: ProcedureFiles, tables: CharacterisationFiles | None = None
) -> ProcedureWork:
    """The work of a procedure for `Engine.submit`, every known step checked; nothing moves.  Raises InputError.

    tables: where a characterisation keeps its report and page; None: in the job's result alone.
    """
    if isinstance(request, CharacteriseRequest):
        return _characterise(engine, request, files, tables)
    fits = OnlineFits(engine.computing)
    return ProcedureWork(_procedure(engine, request, files), EngineSteps(engine), files, fits)


def _procedure(engine: Engine, request: AnyProcedureRequest, files: ProcedureFiles) -> Procedure:
    match request:
        case SweepRequest():
            return Sweep(request)
        case RampRequest():
            return _ramp(engine, request, files)
        case TuneRequest():
            return _tune(engine, request)
    raise InputError(f"no procedure {request.kind!r} can be made", where="kind", remedy="ask for a sweep")


def _tune(engine: Engine, request: TuneRequest) -> Tune:
    specimen, _ = engine.catalogue.resonators.load(request.acquisition.resonator)
    sequence = untuned_sequence(request.acquisition, specimen, engine.catalogue)
    limits, presets = engine.side.limits, engine.catalogue.tuned
    plain = request.acquisition.model_copy(update={"sequence": SequencePatch()})
    preset = untuned_sequence(plain, specimen, engine.catalogue)
    return Tune(request, TuneBench(specimen, preset, sequence, limits, EngineSteps(engine).check, presets))


def _ramp(engine: Engine, request: RampRequest, files: ProcedureFiles) -> Ramp:
    asked = request.acquisition
    planned = engine.plan(asked.model_copy(update={"beyond_side_modes": True}))
    limit_t, earlier = planned.side.limits.max_field_t, planned.specimen.side_modes
    if earlier is not None and not asked.beyond_side_modes:
        limit_t = min(limit_t, earlier.max_field_t)
    preset = engine.plan(asked.model_copy(update={"beyond_side_modes": True, "sequence": SequencePatch()})).sequence
    basis = RampBasis(planned.sequence, limit_t, preset.rx_s + preset.pause_s)
    keep = _keep(engine, request.acquisition.resonator, planned.specimen, files)
    return Ramp(request, basis, keep, ComputedSideModes(engine.computing))


def _characterise(
    engine: Engine, request: CharacteriseRequest, files: ProcedureFiles, tables: CharacterisationFiles | None
) -> ProcedureWork:
    """After tune and a ramp, if asked for; else at the field that an earlier ramp has kept with the specimen."""
    plan = engine.plan(request.acquisition)
    computed_surely(engine.online, "planning", CheckHeld(plan.model, request.held_in_n50))
    tune = _tune(engine, request.tune_request()) if request.tune else None
    ramp = None if request.ramp is None else _ramp(engine, request.ramp_request(), files)
    kept = plan.specimen.side_modes
    procedure = Characterise(request, tune, ramp, None if kept is None else kept.operating_field_t)
    conclusion = CharacteriseConclusion(request, plan.model, tables, procedure, engine.computing)
    return ProcedureWork(procedure, EngineSteps(engine), files, OnlineFits(engine.computing), conclusion)


def _keep(engine: Engine, name: str, specimen: Specimen, files: ProcedureFiles) -> Keep:
    """In the catalogue of a daemon; beside the recording where there is none."""
    if engine.catalogue.resonators.added is not None or files.target is None:
        return keep_in(engine.catalogue, name)
    return keep_beside(specimen, files.target.with_suffix(".toml"))
