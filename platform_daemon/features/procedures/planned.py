"""From a request to the checked work of its procedure; nothing moves."""

from __future__ import annotations

from drivers.errors import InputError
from platform_daemon.core.registry import procedures
from platform_daemon.core.service.bench import HardwareBench

from .bench import ProcedureBench, ReportFiles
from .conductor import ProcedureFiles, ProcedureWork
from .request_schema import ProcedureRequest
from .schema import ProcedureSummary


def plan_procedure(bench: ProcedureBench, request: ProcedureRequest) -> ProcedureWork:
    """The work of a procedure of whatever kind, every known step checked.  Raises InputError."""
    for feature, procedure in procedures():
        if procedure.name == request.kind:
            work: ProcedureWork = feature.load(procedure.plan)(bench, request)
            return work
    raise InputError(f"no procedure {request.kind!r} can be made", where="kind", remedy="ask for a sweep")


def plan(bench: HardwareBench, request: ProcedureRequest) -> ProcedureWork:
    """See plan_procedure; files are those of the daemon's data.  Raises also StorageUnusable, InterlockError."""
    bench.check_named(request.acquisition)
    folders = bench.folders
    files = ProcedureFiles(folders.recordings, folders.procedures)
    reports = ReportFiles(folder=folders.characterisations)
    work = plan_procedure(ProcedureBench(engine=bench.engine, files=files, reports=reports), request)
    summary = work.summary()
    bench.check_feasible(summary.disk_bytes, summary.shots)
    return work


def dry_run(bench: HardwareBench, request: ProcedureRequest) -> ProcedureSummary:
    """The same checks: every step as it would be."""
    return plan(bench, request).summary()
