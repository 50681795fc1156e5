"""From a request to the work of its procedure."""

from __future__ import annotations

from drivers.errors import InputError
from drivers.specimen import Specimen
from platform_daemon.schemas import AnyProcedureRequest, RampRequest, SweepRequest

from ..engine import Engine
from .conductor import ProcedureFiles, ProcedureWork
from .engine_steps import EngineSteps
from .kept_limits import Keep, keep_beside, keep_in
from .procedure import Procedure
from .ramp import Ramp, RampBasis
from .sweep import Sweep


def plan_procedure(engine: Engine, request: AnyProcedureRequest, files: ProcedureFiles) -> ProcedureWork:
    """The work of a procedure for `Engine.conduct`, every known step checked; nothing moves.  Raises InputError."""
    return ProcedureWork(_procedure(engine, request, files), EngineSteps(engine), files)


def _procedure(engine: Engine, request: AnyProcedureRequest, files: ProcedureFiles) -> Procedure:
    match request:
        case SweepRequest():
            return Sweep(request)
        case RampRequest():
            planned = engine.plan(request.acquisition.model_copy(update={"beyond_side_modes": True}))
            basis = RampBasis(planned.sequence, planned.side.limits.max_field_t)
            return Ramp(request, basis, _keep(engine, request.acquisition.resonator, planned.specimen, files))
    raise InputError(f"no procedure {request.kind!r} can be made", where="kind", remedy="ask for a sweep")


def _keep(engine: Engine, name: str, specimen: Specimen, files: ProcedureFiles) -> Keep:
    """In the catalogue of a daemon; beside the recording where there is none."""
    if engine.catalogue.resonators.added is not None or files.target is None:
        return keep_in(engine.catalogue, name)
    return keep_beside(specimen, files.target.with_suffix(".toml"))
