"""Short series on an engine."""

from __future__ import annotations

from pathlib import Path

from platform_daemon.core.hardware.engine import Engine
from platform_daemon.core.jobs.jobs import Job
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.features.acquire.destination import OwnFile
from platform_daemon.features.acquire.series_plan import plan_series, series_work

SHORT_JEWEL = {"resonator": "jewel", "sequence": {"rx_s": 0.6}}
"""A jewel shot of 0.6 s: long enough for a fit, quick to simulate."""


SHORT = {"rx_s": 0.6}
"""The same as arguments of the client."""


def acquire(engine: Engine, target: Path, **keys: object) -> Job:
    """Run one acquisition to its end."""
    request = AcquisitionRequest(**{**SHORT_JEWEL, **keys})  # type: ignore[arg-type]
    job = engine.submit(series_work(engine, plan_series(engine, request), OwnFile(target, target.parent)))
    assert job.ended.wait(timeout=120)
    return job
