"""A series of shots: each is on disk before it counts, fits run meanwhile, and stored shots survive any failure."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import structlog

from drivers.errors import DeviceFault, DeviceStateError
from drivers.platform import Platform
from platform_daemon.core.hardware.calibration_in_use import ChainTest
from platform_daemon.core.hardware.latency import reduce_latency
from platform_daemon.core.hardware.live_estimate import LiveEstimate
from platform_daemon.core.hardware.shot import RawShot, run_shot
from platform_daemon.core.jobs.events import EventSink, null_sink, shot_event
from platform_daemon.core.jobs.jobs import Cancelled, Job
from platform_daemon.core.jobs.workers.task_executor import TaskExecutor
from platform_daemon.core.recordings.header import FitTable, ShotRecord
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recording import StepLabel
from platform_daemon.core.schemas.acquisitions import AcquisitionResult, AcquisitionSummary
from platform_daemon.core.schemas.fits import FitReport, FrameFit
from platform_daemon.core.schemas.requests import AcquisitionRequest
from sequences.compiler import ShotPlan, TransmitSide

from .background_writer import BackgroundWriter
from .destination import Destination, ShotSink
from .planning import AcquisitionPlan
from .series_fits import SeriesFits
from .series_records import Lateness, header_of_shot, series_header, shot_record, shot_report, store_calibration
from .shot_sequence import ShotsInTurn

log = structlog.get_logger()
AcquisitionJob = Job[AcquisitionRequest, AcquisitionResult]
MAX_REFUSED_IN_A_ROW = 3
PAUSE_STEP_S = 0.1
_LOOK_S = 3600.0
_BEFORE_STORED = 0.98  # of a shot that is measured and not on the disk yet


@dataclass(frozen=True, kw_only=True)
class SeriesBench:
    """What every series of an engine is made with.

    Attributes:
        config_text: stored in every recording.
        fits: runs on-line fits, one at a time; online: computes them and plans drives.
        live: gets every shot.
        side: the transmit side of now.
        in_shot: called once in every RX window.
        chain_test: comes first, None: none.
        tell: takes events.
    """

    platform: Platform
    config_text: str
    fits: Executor
    online: TaskExecutor
    live: LiveEstimate
    side: Callable[[], TransmitSide]
    in_shot: Callable[[], None] = lambda: None
    chain_test: ChainTest | None = None
    tell: EventSink = null_sink


class SeriesWork:
    """The work of one acquisition job.  step: of a procedure, None: it belongs to none.

    Raises DeviceStateError if the transmit side is no longer the planned one.
    """

    kind, unit, no_result = "acquisition", "shots", AcquisitionResult()

    def __init__(
        self, bench: SeriesBench, plan: AcquisitionPlan, destination: Destination, step: StepLabel | None = None
    ) -> None:
        self.request, self.total = plan.request, len(plan.shots)
        self._bench, self._platform, self._plan = bench, bench.platform, plan
        self._check_side()
        self._destination, self._turns = destination, ShotsInTurn(plan, step, bench.online)
        self._calibration = store_calibration(bench.platform)
        self._fits = SeriesFits(plan, bench.fits, bench.online, bench.live, self._calibration, bench.tell)
        self._refused_in_a_row = self._refused = self._joined = 0
        self._warned, self._without_temperature = False, 0
        self._left: Callable[[], None] | None = None
        self._told = plan.excited  # by the header
        self._waits_s = [plan.sequence.pause_s * (k > 0 or destination.goes_on) for k in range(self.total)]

    @property
    def duration_s(self) -> float:
        """See Work."""
        return self._plan.summary().duration_s

    def summary(self) -> AcquisitionSummary:
        """What the series would be; nothing moves."""
        return self._plan.summary()

    def __call__(self, job: AcquisitionJob) -> None:
        """Mount, test the chain, shoot, store, fit.

        Raises StorageUnusable before anything moves, what the chain test raises before there is a file, Cancelled,
        DeviceError, OSError; shots already stored stay in it.
        """
        if not self._rested(job):
            return  # nothing moves, not even for the self-test
        self._check_side()
        self._lateness = Lateness(self._platform.clock.monotonic_s(), self._plan.sequence.pause_s)
        self._destination.check(self._plan.disk_bytes, self.total)
        job.warnings += self._plan.warnings
        self._platform.mount(self._plan.specimen)
        self._prove_wiring(job)
        reduce_latency()
        header = series_header(self._plan, self._platform, self._bench.config_text)
        with self._destination.open(header, job.identifier) as series:
            try:
                with BackgroundWriter() as disk:
                    self._shoot_all(job, series, disk)
                    disk.wait()
            finally:
                self._finish(job, series)

    def _shoot_all(self, job: AcquisitionJob, series: ShotSink, disk: BackgroundWriter) -> None:
        """Make all shots.  Each is stored and fitted while the next one is played, and counts once it is stored."""
        try:
            first = self._take_up(job, series)
            job.expect([self._lasts_s(k) for k in range(self.total)])
            for done in range(first, self.total):
                self._pause(job, done, series)
                if not self._rested(job):
                    return  # a safe point: the procedure requests the remaining shots when it is resumed
                shot = self._next_shot(job, done)
                raw = self._shoot(job, shot, done, series)
                self._catch_up()  # `_shoot` does it during reception, which a shot refused before does not reach
                self._left = partial(self._keep, job, series, disk, shot, raw, done)
                self._warn(job, raw, done + 1)
                self._count_refusals(job, raw, done + 1)
        finally:
            self._catch_up()

    def _take_up(self, job: AcquisitionJob, series: ShotSink) -> int:
        """Number of shots on disk from an earlier run; they are fitted again."""
        self._joined = series.shots
        if (reported := job.result.shots or 0) > series.shots:
            job.warnings.append(
                f"resume: {reported - series.shots} of {reported} shots are missing on the disk, and are measured again"
            )
        files = [series.shot_file(number) for number in range(1, series.shots + 1)]
        infos = [open_recording(file).frame_info[0] for file in files]
        reports = [shot_report(info, k + 1, k) for k, info in enumerate(infos)]
        job.shots.taken_up(reports)
        for file, info, report in zip(files, infos, reports, strict=True):
            if report.verdict != "good":
                self._fits.refused(info.reason)
                self._refused += not info.blank
                continue
            there: Future[Path] = Future()
            there.set_result(file)
            self._fits.take(job, there, info.temperature_c, blank=info.blank)
        job.at(series.shots, "go on")
        return series.shots

    def _check_side(self) -> None:
        """Check that the transmit calibration is that of the plan: when the work is made, and when it begins."""
        if self._plan.side is not self._bench.side():
            what = "the transmit calibration has changed since the plan was made"
            raise DeviceStateError(what, remedy="request the series again")

    def _rested(self, job: AcquisitionJob) -> bool:
        """Wait while the job is paused.  False: its procedure has to make the pause.  Raises Cancelled."""
        while job.pause_requested.is_set():
            if job.within is not None:
                return False
            self._catch_up()
            job.rest(_LOOK_S)
            if job.cancel_requested.is_set():
                raise Cancelled
        return True

    def _catch_up(self) -> None:
        """Store and fit the shot before, if that is still to be done."""
        left, self._left = self._left, None
        if left is not None:
            left()

    def _next_shot(self, job: AcquisitionJob, done: int) -> ShotPlan:
        """The plan of the next shot; with `phase_plan = "last_fit"` it waits for the fit of the last one."""
        if self._turns.waits_for_fits:
            self._catch_up()
            job.at(done, f"shot {done + 1}: plan the drive")
        shot = self._turns.shot(done, self._fits.frames)
        job.warnings += self._turns.warnings
        self._turns.warnings = []
        return shot

    def _keep(
        self, job: AcquisitionJob, series: ShotSink, disk: BackgroundWriter, shot: ShotPlan, raw: RawShot, done: int
    ) -> None:
        """Begin to store and to fit a shot.  Raises the error of an earlier shot that could not be stored."""
        joined = 0 < done == self._joined
        record = shot_record(shot, raw, self._lateness.of(shot, raw), self._turns.label(done), joined=joined)
        storing = disk.put(partial(self._store, job, series, shot, record))
        if raw.reason is not None:
            self._fits.refused(raw.reason)
        else:
            self._fits.take(job, storing, raw.temperature_c, blank=shot.blank)

    def _prove_wiring(self, job: AcquisitionJob) -> None:
        chain_test = self._bench.chain_test
        if chain_test is None or not chain_test.enabled:
            return
        job.at(0, "self-test")
        chain_test(job.cancel_requested.is_set)

    def _store(self, job: AcquisitionJob, series: ShotSink, plan: ShotPlan, shot: ShotRecord) -> Path:
        """Store a shot and return its file; from then on the job's record on disk says where the shots are."""
        if not plan.blank and plan is not self._told:
            series.go_on_with(header_of_shot(series.header, plan, self._platform))
            self._told = plan
        stored = series.add_shot(shot)
        self._refused += shot.verdict == "refused" and not shot.blank
        job.result = AcquisitionResult(
            recording=series.target.stem,
            file=series.target.name,
            shots=stored,
            refused=self._refused or None,
            value_sources=self._plan.value_sources,
        )
        job.at(stored, job.phase)  # progress that is published, or found after a crash, counts whole shots
        job.on_change(job)
        report = shot_report(shot, stored, series.frames - 1)
        job.shots.stored(report)
        self._bench.tell(shot_event(job, series.target.stem, report))
        return series.last_shot

    def _shoot(self, job: AcquisitionJob, shot: ShotPlan, done: int, series: ShotSink) -> RawShot:
        total, looked, pause_s = shot.timeline.total_samples, False, self._waits_s[done]

        def tell(samples: int) -> None:
            nonlocal looked
            phase = "excite" if samples < shot.timeline.rx_start else "listen"
            passed_s = pause_s + shot.timeline.duration_s * samples / total
            self._at(job, series, done, passed_s, phase)
            self._catch_up()  # now that it costs no time between shots, and so with the read-back
            if shot.timeline.rx_start < samples < total and not looked:
                looked = True
                self._bench.in_shot()

        self._at(job, series, done, pause_s, "prepare")
        return run_shot(self._platform, shot, cancelled=job.cancel_requested.is_set, progress=tell)

    def _pause(self, job: AcquisitionJob, done: int, series: ShotSink) -> None:
        """Wait `pause_s` of platform time between shots, looking at cancel and pause."""
        pause_s = left = self._waits_s[done]
        if left > 0:
            self._catch_up()
        while True:
            if job.cancel_requested.is_set():
                raise Cancelled
            if left <= 0 or job.pause_requested.is_set():
                return
            self._platform.clock.sleep(min(left, PAUSE_STEP_S))
            left -= PAUSE_STEP_S
            self._at(job, series, done, pause_s - max(0.0, left), "wait")

    def _at(self, job: AcquisitionJob, series: ShotSink, done: int, passed_s: float, phase: str) -> None:
        """So long into the shot after `done`, its pause included; only shots on the disk count as whole."""
        share = passed_s / self._lasts_s(done)
        job.at(min(done + _BEFORE_STORED * share, series.shots + _BEFORE_STORED), f"shot {done + 1}: {phase}")

    def _lasts_s(self, done: int) -> float:
        """The shot after `done`, with the pause before it."""
        return self._waits_s[done] + self._plan.shots[done].timeline.duration_s

    def _warn(self, job: AcquisitionJob, raw: RawShot, number: int) -> None:
        """What is not known of a shot; said again only after a shot of which it was known."""
        if raw.warnings and not self._warned:
            job.warnings += [f"shot {number}: {text}" for text in raw.warnings]
        self._warned = bool(raw.warnings)
        self._without_temperature += self._warned

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

    def _finish(self, job: AcquisitionJob, series: ShotSink) -> None:
        """Wait for the fits, put the series file together, say what came out; no shot leaves no file."""
        stored = series.shots
        job.kept(stored)
        job.at(stored, "fit")
        started = time.monotonic()
        outcomes = self._fits.outcomes(stored)
        made = self._together(job, series, outcomes)
        job.at(stored, "write")
        path = series.finish([] if made is None else [made[0]])
        if path is None:
            return
        if self._without_temperature > 1:
            job.warnings.append(f"{self._without_temperature} shots were made without a known temperature")
        if made is not None:
            # It may be silence, from a switch that cannot be read back.
            job.warnings += [
                f"shot {k + 1} cannot be fitted: {fit.reason}"
                for k, fit in enumerate(outcomes)
                if not isinstance(fit, str) and not fit.good
            ]
            job.result = job.result.model_copy(update={"fit": made[1]})
        log.info("series_written", file=path.name, shots=stored, waited_s=round(time.monotonic() - started, 3))

    def _together(
        self, job: AcquisitionJob, series: ShotSink, outcomes: list[FrameFit | str]
    ) -> tuple[FitTable, FitReport] | None:
        """Table and report of the fits; None, with a warning, where they are lost: the shots are not."""
        try:
            return self._fits.together(series.target.name, outcomes) if outcomes else None
        except Exception as error:
            log.error("fits_lost", exc_info=error)
            job.warnings.append(f"the on-line fits are lost: {error}; fit the recording again")
            return None
