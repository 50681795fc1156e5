"""The on-line fits of a series: each from the stored file of its shot, in order, while further shots are made."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future
from functools import partial
from pathlib import Path

import structlog

from drivers.calibration import ReceiveCalibration
from platform_daemon.core.hardware.live_estimate import LiveEstimate
from platform_daemon.core.jobs.events import EventSink, fit_event, null_sink
from platform_daemon.core.jobs.jobs import AnyJob
from platform_daemon.core.jobs.run_task import run_task_with_retry
from platform_daemon.core.jobs.workers.task_executor import TaskExecutor
from platform_daemon.core.recordings.header import FitTable
from platform_daemon.core.schemas.fits import BLANK, FitReport, FrameFit, unfitted
from platform_daemon.design.equations import expected_moment

from .planning import AcquisitionPlan

log = structlog.get_logger()
KIND = "series-fit"


class SeriesFits:
    """The on-line fits of one series.  Written by the thread of the series and by that of the fits.

    turns: runs the fits one at a time; executor: fits; live: receives the harmonics of every shot; calibration: of the
    platform; tell: takes events.
    """

    def __init__(
        self,
        plan: AcquisitionPlan,
        turns: Executor,
        executor: TaskExecutor,
        live: LiveEstimate,
        calibration: ReceiveCalibration,
        tell: EventSink = null_sink,
    ) -> None:
        self._plan, self._turns, self._executor, self._live = plan, turns, executor, live
        self._calibration, self._tell = calibration, tell
        self._window = plan.request.window
        self.frames: list[Future[FrameFit] | str] = []
        self._without_fit: set[Future[FrameFit]] = set()  # harmonics, and the noise of blank shots, not yet done
        self._noise: bytes | None = None

    def refused(self, reason: str) -> None:
        """The next shot is not to be fitted."""
        self.frames.append(reason)

    def take(self, job: AnyJob, stored: Future[Path], temperature_c: float | None, *, blank: bool) -> None:
        """The next shot, whose file will be there."""
        frame = len(self.frames)
        work = partial(self._fit, job, frame, stored, temperature_c, blank=blank)
        if blank:
            self.frames.append("no on-line fit was requested" if self._window is None else BLANK)
            if self._window is not None:
                self._begin_without_fit(work)
        elif self._window is None:
            self.frames.append("no on-line fit was requested")
            self._begin_without_fit(work)
        else:
            self.frames.append(self._turns.submit(work))

    def _begin_without_fit(self, work: Callable[[], FrameFit]) -> None:
        begun = self._turns.submit(work)
        self._without_fit.add(begun)
        begun.add_done_callback(_complain)
        begun.add_done_callback(self._without_fit.discard)

    def outcomes(self, shots: int) -> list[FrameFit | str]:
        """The fit of each of the first shots, or why there is none; waits for them.

        What still waits for its turn without a fit is cancelled: the files of the shots will be put together, and it
        would not find them.
        """
        found = [fit if isinstance(fit, str) else _outcome(k, fit) for k, fit in enumerate(self.frames[:shots])]
        for each in tuple(self._without_fit):
            if not each.cancel():
                each.exception()  # waits for the one that is being made
        return found

    def together(self, file: str, outcomes: list[FrameFit | str]) -> tuple[FitTable, FitReport] | None:
        """Table and report of a recording; None: no fit was requested.  Raises what the executor raises."""
        from platform_daemon.features.fit.online import SeriesTable

        if self._window is None:
            return None
        task = SeriesTable(file, self._plan.model, self._window, self._calibration, outcomes)
        made = run_task_with_retry(self._executor, KIND, task)
        return made.table, made.report

    def _fit(
        self, job: AnyJob, frame: int, stored: Future[Path], temperature_c: float | None, *, blank: bool
    ) -> FrameFit:
        """In the fits' one thread: the noise grows ahead of each fit.  Raises what kept the shot from the disk."""
        from platform_daemon.features.fit.online import OnlineFit

        task = OnlineFit(
            stored.result(),
            self._calibration,
            self._plan.model,
            self._window,
            expected_moment(self._plan.specimen),
            temperature_c,
            blank,
            self._noise,
        )
        try:
            found = run_task_with_retry(self._executor, KIND, task)
        except Exception as error:
            self._tell(fit_event(job, frame + 1, unfitted(frame, _failed(error))))
            raise
        self._noise = found.noise
        if found.harmonics is not None:
            self._live.see(job.identifier, frame + 1, found.harmonics)
        if found.frame is None:
            return unfitted(frame, BLANK)
        fit = found.frame.model_copy(update={"frame": frame})
        job.shots.fitted(frame + 1, fit)
        self._tell(fit_event(job, frame + 1, fit, self._plan.specimen.name, temperature_c))
        return fit


def _outcome(frame: int, fit: Future[FrameFit]) -> FrameFit | str:
    error = fit.exception()
    if error is not None:
        log.error("fit_failed", exc_info=error)
        return _failed(error)
    return fit.result()


def _failed(error: BaseException) -> str:
    return f"the fit failed: {type(error).__name__}: {error}"


def _complain(side_work: Future[FrameFit]) -> None:
    """A live view or a noise estimate that failed costs the series nothing else."""
    if not side_work.cancelled() and side_work.exception() is not None:
        log.error("shot_side_work_failed", exc_info=side_work.exception())
