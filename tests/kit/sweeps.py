"""Short sweeps on an engine."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from platform_daemon.core.hardware.engine import Engine
from platform_daemon.features.procedures.bench import ProcedureBench
from platform_daemon.features.procedures.conductor import ProcedureFiles, ProcedureWork
from platform_daemon.features.procedures.planned import plan_procedure
from platform_daemon.features.procedures.procedure import ProcedureJob
from platform_daemon.features.sweep.schema import SweepRequest

FIELDS = {"key": "field_ut", "values": [200, 300, 400]}


def sweep_request(*over: dict[str, Any], stop_when: Any = None, longest_pause_s: float = 60.0, **keys: Any) -> Any:
    """A sweep of short jewel shots without fits, over three fields unless other keys are given."""
    return {
        "kind": "sweep",
        "acquisition": {"resonator": "jewel", "sequence": {"rx_s": 0.3}, "window": None, **keys},
        "over": list(over) or [FIELDS],
        "stop_when": stop_when,
        "longest_pause_s": longest_pause_s,
    }


def sweep_work(engine: Engine, folder: Path, *over: dict[str, Any], **keys: Any) -> ProcedureWork:
    """Its work, which writes `folder`/s.h5 and s.json."""
    files = ProcedureFiles(folder, folder, folder / "s.h5", folder / "s.json")
    return plan_procedure(
        ProcedureBench(engine=engine, files=files), SweepRequest.model_validate(sweep_request(*over, **keys))
    )


def swept(engine: Engine, folder: Path, *over: dict[str, Any], **keys: Any) -> ProcedureJob:
    """Its job, once it has ended."""
    job = engine.submit(sweep_work(engine, folder, *over, **keys))
    assert job.ended.wait(timeout=120)
    return job
