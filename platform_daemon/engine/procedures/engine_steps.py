"""Steps made by an engine in this process, by its public `submit` like anybody else's work."""

from __future__ import annotations

from platform_daemon.schemas import AcquisitionRequest, AcquisitionSummary
from platform_daemon.store import StepLabel

from ..engine import Engine
from ..jobs import AnyJob
from ..work.destination import Destination
from ..work.series import AcquisitionJob, SeriesWork


class EngineSteps:
    """See Steps."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine

    def check(self, request: AcquisitionRequest) -> AcquisitionSummary:
        """See Steps."""
        return self._engine.plan(request).summary()

    def begin(
        self, request: AcquisitionRequest, destination: Destination, label: StepLabel, within: AnyJob
    ) -> AcquisitionJob:
        """See Steps.  The plan holds until the step is made: no calibration is changed while a procedure runs."""
        work = SeriesWork(self._engine.series_bench, self._engine.plan(request), destination, label)
        return self._engine.submit(work, within)
