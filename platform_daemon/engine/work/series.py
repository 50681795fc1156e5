"""A series of shots: each is on disk before it counts, fits run beside, and what was made is kept whatever happens."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
import structlog

from drivers.errors import DeviceFault
from drivers.platform import Platform
from platform_daemon import analysis, estimation
from platform_daemon.design import expected_moment
from platform_daemon.schemas import AcquisitionRequest, AcquisitionResult, FrameFit, unfitted
from platform_daemon.store import ShotRecord, StepLabel
from sequences.compiler import ShotPlan

from ..jobs import Cancelled, Job
from ..latency import reduce_latency
from ..live_estimate import LiveEstimate
from ..planning import AcquisitionPlan
from ..shot import RawShot, run_shot
from .destination import Destination, ShotSink
from .self_test import SelfTest
from .series_records import header_of_shot, series_header, shot_record, store_calibration
from .shots_in_turn import ShotsInTurn

if TYPE_CHECKING:
    from platform_daemon.estimation import FitResult

log = structlog.get_logger()
AcquisitionJob = Job[AcquisitionRequest, AcquisitionResult]
MAX_REFUSED_IN_A_ROW = 3
PAUSE_STEP_S = 0.1


@dataclass(frozen=True)
class SeriesBench:
    """What every series of an engine is made with.

    config_text: stored in every recording; fits: runs on-line fits, one at a time; live: is told every shot; in_shot:
    called once in every RX window; self_test: comes first, None: none.
    """

    platform: Platform
    config_text: str
    fits: Executor
    live: LiveEstimate
    in_shot: Callable[[], None] = lambda: None
    self_test: SelfTest | None = None


class SeriesWork:
    """The work of one acquisition job.  step: of a procedure, None: it stands for itself."""

    kind, unit, no_result = "acquisition", "shots", AcquisitionResult()

    def __init__(
        self, bench: SeriesBench, plan: AcquisitionPlan, destination: Destination, step: StepLabel | None = None
    ) -> None:
        self.request, self.total = plan.request, len(plan.shots)
        self._bench, self._platform, self._plan = bench, bench.platform, plan
        self._destination, self._turns = destination, ShotsInTurn(plan, step)
        self._calibration = store_calibration(bench.platform)
        undone = plan.model.receiver if isinstance(plan.model, analysis.AdoptedModel) else ()
        self._of_fits = replace(self._calibration, receiver=undone)
        self._fits: list[Future[FitResult] | str] = []
        self._noise = estimation.SeriesNoise()  # grows in the fits' one thread, ahead of each fit
        self._refused_in_a_row = self._refused = 0
        self._left: Callable[[], None] | None = None
        self._storing: Future[None] | None = None
        self._told = plan.excited  # by the header

    def __call__(self, job: AcquisitionJob) -> None:
        """Mount, test the chain, shoot, store, fit.

        Raises SelfTestFailed before there is a file, Cancelled, DeviceError, OSError; shots already stored stay in it.
        """
        if job.pause_requested.is_set():
            return  # while it waited; nothing moves, not even for the self-test
        job.warnings += self._plan.warnings
        self._platform.mount(self._plan.specimen)
        self._prove_wiring(job)
        reduce_latency()
        header = series_header(self._plan, self._platform, self._bench.config_text)
        with self._destination.open(header, job.identifier) as series:
            try:
                with ThreadPoolExecutor(max_workers=1, thread_name_prefix="disk") as disk:
                    self._shoot_all(job, series, disk)
                    _raise_failure(self._storing)
            finally:
                self._finish(job, series)

    def _shoot_all(self, job: AcquisitionJob, series: ShotSink, disk: Executor) -> None:
        """Shot after shot; each goes to disk and to its fit while the next one is played, and counts from then on."""
        try:
            for done in range(len(self._plan.shots)):
                self._pause(job, first=done == 0 and not self._destination.goes_on)
                if job.pause_requested.is_set():
                    return  # a safe point: what is left is asked for again once its procedure is resumed
                shot = self._next_shot(job, done)
                raw = self._shoot(job, shot, done + 1, series)
                self._catch_up()  # a shot that was refused at its beginning has not come to it
                self._left = partial(self._keep, job, series, disk, shot, raw, done)
                self._count_refusals(job, raw, done + 1)
        finally:
            self._catch_up()

    def _catch_up(self) -> None:
        """What is left to do of the shot before."""
        left, self._left = self._left, None
        if left is not None:
            left()

    def _next_shot(self, job: AcquisitionJob, done: int) -> ShotPlan:
        """The shot to be made next, which may have to wait for the fit of the last one."""
        if self._turns.waits_for_fits:
            self._catch_up()
            job.at(done, f"shot {done + 1}: plan the drive")
        shot = self._turns.shot(done, self._fits)
        job.warnings += self._turns.warnings
        self._turns.warnings = []
        return shot

    def _keep(
        self, job: AcquisitionJob, series: ShotSink, disk: Executor, shot: ShotPlan, raw: RawShot, done: int
    ) -> None:
        """Begin to store and to fit a shot.  Raises what kept the shot before from being stored."""
        _raise_failure(self._storing)
        self._storing = disk.submit(self._store, job, series, shot, shot_record(shot, raw, self._turns.label(done)))
        self._storing.add_done_callback(_complain)
        self._follow_up(job, shot, raw)

    def _prove_wiring(self, job: AcquisitionJob) -> None:
        self_test = self._bench.self_test
        if self_test is None or not self_test.enabled:
            return
        job.at(0, "self-test")
        heard = self_test(job.cancel_requested.is_set)
        log.info("self_test_passed", **({} if heard is None else heard.model_dump()))

    def _store(self, job: AcquisitionJob, series: ShotSink, plan: ShotPlan, shot: ShotRecord) -> None:
        """Once this is done the job's record says where the shots are, whatever happens to the process."""
        if not plan.blank and plan is not self._told:
            series.go_on_with(header_of_shot(series.header, plan, self._platform))
            self._told = plan
        stored = series.add_shot(shot)
        self._refused += shot.verdict == "refused" and not shot.blank
        job.result = AcquisitionResult(
            recording=series.target.stem, file=series.target.name, shots=stored, refused=self._refused or None
        )
        job.on_change(job)

    def _shoot(self, job: AcquisitionJob, shot: ShotPlan, number: int, series: ShotSink) -> RawShot:
        total, looked = shot.timeline.total_samples, False

        def tell(samples: int) -> None:
            nonlocal looked
            phase = "excite" if samples < shot.timeline.rx_start else "listen"
            job.at(series.shots + 0.98 * samples / total, f"shot {number}: {phase}")
            self._catch_up()  # now that it costs no time between shots, and so with the read-back
            if shot.timeline.rx_start < samples < total and not looked:
                looked = True
                self._bench.in_shot()

        job.at(series.shots, f"shot {number}: prepare")
        return run_shot(self._platform, shot, cancelled=job.cancel_requested.is_set, progress=tell)

    def _pause(self, job: AcquisitionJob, *, first: bool) -> None:
        """Wait `pause_s` of platform time between shots, looking at cancel and pause."""
        left = 0.0 if first else self._plan.sequence.pause_s
        if left > 0:
            self._catch_up()
        while True:
            if job.cancel_requested.is_set():
                raise Cancelled
            if left <= 0 or job.pause_requested.is_set():
                return
            self._platform.clock.sleep(min(left, PAUSE_STEP_S))
            left -= PAUSE_STEP_S

    def _count_refusals(self, job: AcquisitionJob, raw: RawShot, number: int) -> None:
        """Give up after too many refused shots in a row."""
        if raw.reason is None:
            self._refused_in_a_row = 0
            return
        job.warnings.append(f"shot {number} refused: {raw.reason}")
        self._refused_in_a_row += 1
        if self._refused_in_a_row >= MAX_REFUSED_IN_A_ROW:
            raise DeviceFault(
                f"{MAX_REFUSED_IN_A_ROW} shots in a row were refused",
                why=raw.reason,
                remedy="find the cause named; the shots are kept in the recording, marked refused",
            )

    def _follow_up(self, job: AcquisitionJob, shot: ShotPlan, raw: RawShot) -> None:
        """Start the on-line fit of a good shot."""
        if raw.reason is not None:
            self._fits.append(raw.reason)
            return
        window = self._plan.request.window
        rx, rate_hz = raw.volts[:, shot.timeline.rx_start :].astype(np.float64), shot.timeline.clock.rate_hz
        if not shot.blank:
            shown = self._bench.fits.submit(
                self._bench.live.see, job.identifier, len(self._fits) + 1, rx, rate_hz, self._calibration
            )
            shown.add_done_callback(_complain)
        if window is None:
            self._fits.append("no on-line fit was asked for")
            return
        heard = self._bench.fits.submit(analysis.learn_noise, self._noise, rx, rate_hz, self._of_fits, blank=shot.blank)
        heard.add_done_callback(_complain)
        if shot.blank:
            self._fits.append(analysis.BLANK)
            return
        ask = analysis.FitRequest(self._plan.model, window, moment_am2=expected_moment(self._plan.specimen))
        taken = estimation.Conditions(raw.temperature_c, self._calibration.lna_gain)
        self._fits.append(
            self._bench.fits.submit(analysis.fit_frame, rx, rate_hz, self._of_fits, ask, self._noise, taken)
        )

    def _finish(self, job: AcquisitionJob, series: ShotSink) -> None:
        """Wait for the fits, put the series file together, say what came out; no shot leaves no file."""
        stored = series.shots
        job.at(stored, "fit")
        started = time.monotonic()
        window = self._plan.request.window
        fits = [fit if isinstance(fit, str) else _outcome(fit) for fit in self._fits[:stored]]
        tables = [] if window is None else [analysis.fit_table(str(window), analysis.label_of(self._plan.model), fits)]
        job.at(stored, "write")
        path = series.finish(tables)
        if path is None:
            return
        if window is not None:
            frames = [_frame_fit(k, fit) for k, fit in enumerate(fits)]
            # It may be silence, from a switch that cannot be read back.
            job.warnings += [
                f"shot {f.frame + 1} cannot be fitted: {f.reason}"
                for f, fit in zip(frames, fits, strict=True)
                if not isinstance(fit, str) and not f.good
            ]
            ask = analysis.FitRequest(self._plan.model, window)
            report = analysis.file_report(path.name, ask, frames, self._calibration)
            job.result = job.result.model_copy(update={"fit": report})
        log.info("series_written", file=path.name, shots=stored, waited_s=round(time.monotonic() - started, 3))


def _raise_failure(storing: Future[None] | None) -> None:
    """Wait until the shot before is on disk.  Raises why it is not."""
    if storing is not None:
        storing.result()


def _complain(side_work: Future[None]) -> None:
    """A live view or a noise estimate that failed costs the series nothing else."""
    if not side_work.cancelled() and side_work.exception() is not None:
        log.error("shot_side_work_failed", exc_info=side_work.exception())


def _outcome(fit: Future[FitResult]) -> FitResult | str:
    error = fit.exception()
    if error is not None:
        log.error("fit_failed", exc_info=error)
        return f"the fit failed: {type(error).__name__}: {error}"
    return fit.result()


def _frame_fit(frame: int, fit: FitResult | str) -> FrameFit:
    return unfitted(frame, fit) if isinstance(fit, str) else analysis.frame_report(frame, fit)
