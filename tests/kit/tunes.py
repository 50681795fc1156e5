"""Tunes on an engine, of resonators that are not what their design says."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from platform_daemon.core.hardware.catalogue import Catalogue
from platform_daemon.core.hardware.engine import Engine
from platform_daemon.core.settings import load_specimen, locate
from platform_daemon.features.procedures.bench import ProcedureBench
from platform_daemon.features.procedures.conductor import ProcedureFiles, ProcedureWork
from platform_daemon.features.procedures.planned import plan_procedure
from platform_daemon.features.procedures.procedure import ProcedureJob
from platform_daemon.features.tune.presets import TunedPresets
from platform_daemon.features.tune.schema import TuneRequest

DESIGN_HZ = 229.308  # of the magnets that all shipped resonators declare


def off_design(folder: Path, bearing: str, f_nat_hz: float) -> str:
    """The file of a shipped resonator whose simulated rotor has another frequency than its magnets say."""
    text = locate("resonators", bearing).read_text(encoding="utf-8")
    path = folder / f"own-{bearing}.toml"
    path.write_text(re.sub(r"f_nat_hz = [\d.]+", f"f_nat_hz = {f_nat_hz}", text), encoding="utf-8")
    assert load_specimen(path)[0].measured.f_nat_hz == f_nat_hz
    return str(path)


def tune_request(resonator: str, *, sequence: dict[str, Any] | None = None, **keys: Any) -> dict[str, Any]:
    """A tune."""
    return {"kind": "tune", "acquisition": {"resonator": resonator, "sequence": sequence or {}}, **keys}


def tune_work(engine: Engine, folder: Path, resonator: str, **keys: Any) -> ProcedureWork:
    """Its work, which writes `folder`/t.h5 and t.json, and presets into `folder`/presets."""
    engine.catalogue = Catalogue(tuned=TunedPresets(folder / "presets"))
    files = ProcedureFiles(folder, folder, folder / "t.h5", folder / "t.json")
    return plan_procedure(
        ProcedureBench(engine=engine, files=files), TuneRequest.model_validate(tune_request(resonator, **keys))
    )


def tuned(engine: Engine, folder: Path, resonator: str, **keys: Any) -> ProcedureJob:
    """Its job, once it has ended."""
    job = engine.submit(tune_work(engine, folder, resonator, **keys))
    assert job.ended.wait(timeout=120)
    return job
