"""Short series on an engine."""

from __future__ import annotations

from pathlib import Path

from platform_daemon.engine.engine import Engine
from platform_daemon.engine.jobs import Job
from platform_daemon.schemas.requests import AcquisitionRequest

SHORT_JEWEL = {"resonator": "jewel", "sequence": {"rx_s": 0.6}}
"""A jewel shot of 0.6 s: long enough for a fit, quick to simulate."""


def acquire(engine: Engine, target: Path, **keys: object) -> Job:
    """Run one acquisition to its end."""
    request = AcquisitionRequest(**{**SHORT_JEWEL, **keys})  # type: ignore[arg-type]
    job = engine.acquire(engine.plan(request), target, target.parent)
    assert job.ended.wait(timeout=120)
    return job
