"""Steps made by an engine in this process, by its public `submit` like anybody else's work."""

from __future__ import annotations

from platform_daemon.core.hardware.engine import Engine
from platform_daemon.core.jobs.jobs import AnyJob
from platform_daemon.core.recordings.recording import StepLabel
from platform_daemon.core.schemas.acquisitions import AcquisitionSummary
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.core.schemas.value_sources import Origins
from platform_daemon.features.acquire.destination import Destination
from platform_daemon.features.acquire.series_plan import plan_series, series_work
from platform_daemon.features.acquire.work import AcquisitionJob


class EngineSteps:
    """See Steps."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine

    def check(self, request: AcquisitionRequest, origins: Origins) -> AcquisitionSummary:
        """See Steps."""
        return plan_series(self._engine, request, origins).summary()

    def begin(
        self, request: AcquisitionRequest, destination: Destination, label: StepLabel, within: AnyJob, origins: Origins
    ) -> AcquisitionJob:
        """See Steps.  The plan holds until the step is made: no calibration is changed while a procedure runs."""
        known = {key: origin.found_by(within.identifier) for key, origin in origins.items()}
        work = series_work(self._engine, plan_series(self._engine, request, known), destination, label)
        return self._engine.submit(work, within)
