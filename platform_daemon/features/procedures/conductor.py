"""The job of a procedure: makes its steps, repeats refused shots, pauses on request, keeps the log, and puts the one
recording together whatever happens."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from pathlib import Path

import structlog

from drivers.errors import DeviceFault, InputError, PlatformError
from platform_daemon import __version__
from platform_daemon.core.jobs.jobs import Cancelled
from platform_daemon.core.jobs.submit_options import ShuttingDown
from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.core.schemas.value_sources import ValueSource
from platform_daemon.core.state.durable import write_file
from platform_daemon.features.acquire.work import AcquisitionJob

from .procedure import Conclusion, Fits, Procedure, ProcedureJob, ReadsShots, Steps
from .schema import PlannedStep, ProcedureLog, ProcedureResult, ProcedureSummary
from .step_report import StepAttempts
from .step_series import StepSeries

log = structlog.get_logger()
MAX_ATTEMPTS = 3
"""A step with refused shots is repeated until this many attempts had some."""
WATCH_S = 0.05


class PauseTooLong(PlatformError):
    """A procedure was paused for longer than it may be."""

    title = "Pause too long"


@dataclass(frozen=True)
class ProcedureFiles:
    """Where a procedure writes: the recording `target`, or `folder`/ID.h5 of the job's id; the log `log`, or
    `logs`/ID.json.

    overwrite: in the place of files that are there.
    """

    folder: Path
    logs: Path
    target: Path | None = None
    log: Path | None = None
    overwrite: bool = False

    def check(self) -> None:
        """Raises InputError if a file is there that may not be overwritten."""
        for path in (self.target, self.log):
            if path is not None and path.exists() and not self.overwrite:
                remedy = "choose another name, or overwrite on purpose (--force)"
                raise InputError("the file exists already", where=str(path), remedy=remedy)


class ProcedureWork:
    """The work of one procedure, every known step of it checked.  Raises InputError that names the step."""

    kind, unit = "procedure", "shots"

    def __init__(
        self,
        procedure: Procedure,
        steps: Steps,
        files: ProcedureFiles,
        fits: Fits,
        conclusion: Conclusion | None = None,
    ) -> None:
        files.check()
        self.request = procedure.request
        self._procedure, self._steps, self._files, self._fits = procedure, steps, files, fits
        self._outline = self._checked()
        self._conclusion = conclusion
        self.total: float = self._outline.shots
        if conclusion is not None:  # its part of the time counts as shots
            self.total /= 1.0 - conclusion.share(self._outline)
        self.no_result = ProcedureResult(planned_steps=len(self._outline.steps) or None, steps=(), stopped=None)
        self._whole = False  # whatever its outline says
        self._before = 0  # planned shots of the steps that are made

    @property
    def duration_s(self) -> float:
        """See Work."""
        return self._outline.duration_s

    def summary(self) -> ProcedureSummary:
        """What the procedure would be; nothing moves."""
        return self._outline

    def record(self, job: ProcedureJob) -> ProcedureLog:
        """The log as it is now."""
        return ProcedureLog(
            software_version=__version__,
            job=job.identifier,
            started="" if job.started is None else job.started.isoformat(),
            request=self.request,
            result=job.result,
        )

    def _checked(self) -> ProcedureSummary:
        planned: list[PlannedStep] = []
        warnings: list[str] = []
        resonator = ""
        sources: tuple[ValueSource, ...] | None = None
        for number, step in enumerate(self._procedure.outline(), start=1):
            try:
                found = self._steps.check(step.acquisition, step.origins)
            except InputError as error:
                raise _at(error, step.named(number)) from None
            resonator, sources = found.resonator, found.value_sources
            warnings += found.warnings
            planned.append(
                PlannedStep(
                    step=number,
                    values=step.values,
                    shots=found.shots,
                    duration_s=found.duration_s,
                    disk_bytes=found.disk_bytes,
                )
            )
        return ProcedureSummary(
            resonator=resonator,
            shots=sum(step.shots for step in planned),
            duration_s=sum(step.duration_s for step in planned),
            disk_bytes=sum(step.disk_bytes for step in planned),
            steps=tuple(planned),
            stop_when=self._procedure.ends_early,
            warnings=tuple(dict.fromkeys(warnings)),
            value_sources=sources,
        )

    def __call__(self, job: ProcedureJob) -> None:
        """Raises Cancelled, DeviceError, StorageError, PauseTooLong; what was measured is in the recording then."""
        target = self._files.target or self._files.folder / f"{job.identifier}.h5"
        title = f"{self._outline.resonator}, {self._procedure.title}"
        series = StepSeries(target, title, self._outline, overwrite=self._files.overwrite)
        ended = "failed"
        job.expect([step.duration_s / step.shots for step in self._outline.steps for _ in range(step.shots)])
        try:
            self._keep_log(job)
            if isinstance(self._procedure, ReadsShots):
                self._procedure.reads(series)
            ended = self._all_steps(job, series)
        except Cancelled:
            ended = "cancelled"
            raise
        except PlatformError as error:
            ended = f"failed: {error}"
            raise
        else:
            self._whole = self._procedure.open_ended
        finally:
            self._finish(job, series, ended)
        self._procedure.conclude(job.identifier, job.result)
        self._learn(job)
        if self._conclusion is not None:
            self._conclude(self._conclusion, job, target)

    def _conclude(self, conclusion: Conclusion, job: ProcedureJob, recording: Path) -> None:
        """From the recording, which stays whatever happens here.  Raises Cancelled, PauseTooLong, PlatformError."""
        measured = job.done

        def tell(phase: str, share: float) -> None:
            job.at(max(job.done, measured + share * (self.total - measured)), phase)
            self._rest(job)

        conclusion(job, recording, tell)
        job.at(job.total, "write")
        self._keep_log(job)

    def _all_steps(self, job: ProcedureJob, series: StepSeries) -> str:
        """Step after step; why it ended."""
        steps = self._procedure.steps()
        number, step = 1, next(steps)
        while True:
            attempts = StepAttempts(number, step, series.shots, job.clock.utc())
            try:
                self._one_step(job, series, attempts)
            finally:  # also of a step that was cut short: its shots are in the recording
                self._report(job, series, attempts)
            self._before += step.acquisition.shots + step.acquisition.blank_shots
            self._advance(job, 0.0, f"step {number}: done")
            try:
                number, step = number + 1, steps.send(job.result.steps[-1])
            except StopIteration as end:
                if self._conclusion is None:
                    job.total = job.done  # what a rule has saved is not left to do
                return str(end.value)
            finally:  # it has learnt from the report
                self._learn(job)

    def _one_step(self, job: ProcedureJob, series: StepSeries, attempts: StepAttempts) -> None:
        """A step, with its refused shots repeated and its pauses.  Raises what ends the procedure."""
        step = attempts.step
        while True:
            self._rest(job)
            shots, blank = attempts.left
            if shots + blank <= 0:
                return
            request = step.acquisition.model_copy(
                update={"shots": shots, "blank_shots": blank, "priority": job.priority}
            )
            made = self._made(job, series, attempts, request)
            if made.state is JobState.CANCELLED:
                raise Cancelled
            if made.error is not None:
                raise _at(made.error, step.named(attempts.number))
            if attempts.refusals >= MAX_ATTEMPTS:
                raise DeviceFault(
                    f"shots were refused in {MAX_ATTEMPTS} attempts",
                    where=step.named(attempts.number),
                    why=made.warnings[-1] if made.warnings else "",
                    remedy="find the cause named; all shots are kept in the recording, those marked refused",
                )

    def _made(
        self, job: ProcedureJob, series: StepSeries, attempts: StepAttempts, request: AcquisitionRequest
    ) -> AcquisitionJob:
        """One attempt, when it has ended."""
        number = attempts.number
        try:
            made = self._steps.begin(request, series, attempts.step.label(number), job, attempts.step.origins)
        except ShuttingDown:  # the shutdown has cancelled this job as well
            raise Cancelled from None
        except PlatformError as error:
            raise _at(error, attempts.step.named(number)) from None
        while not made.ended.wait(timeout=WATCH_S):
            self._advance(job, attempts.shots + made.progress().done, f"step {number}: {made.phase}")
            if job.cancel_requested.is_set():
                made.request_cancel()  # it may still wait in the queue
        attempts.add(made)
        return made

    def _report(self, job: ProcedureJob, series: StepSeries, attempts: StepAttempts) -> None:
        """What the step has brought, in the job and on disk."""
        if attempts.shots == 0:
            return
        report = attempts.report(self._fits, job.clock.utc(), series.last_shot)
        said = {text for earlier in job.result.steps for text in earlier.warnings}
        job.warnings += [f"step {report.step}: {text}" for text in report.warnings if text not in said]
        where = {"recording": series.target.stem, "file": series.target.name}
        job.result = job.result.model_copy(update={**where, "steps": (*job.result.steps, report)})
        self._keep_log(job)
        job.on_change(job)

    def _learn(self, job: ProcedureJob) -> None:
        """What the procedure has made of the last report, in the job and on disk."""
        if self._procedure.outcome is not None:
            job.result = job.result.model_copy(update={"outcome": self._procedure.outcome})
            self._keep_log(job)
            job.on_change(job)

    def _rest(self, job: ProcedureJob) -> None:
        """A safe point: nothing of this procedure moves, or is queued, and outputs are off."""
        longest_s = self.request.longest_pause_s
        if job.pause_requested.is_set():
            log.info("procedure_paused", job=job.identifier)
            if not job.rest(longest_s):
                raise PauseTooLong(
                    f"it was paused for more than {longest_s:g} s",
                    where="longest_pause_s",
                    remedy="ask for the steps that are missing; what was measured is in the recording",
                )
        if job.cancel_requested.is_set():
            raise Cancelled

    def _advance(self, job: ProcedureJob, shots: float, phase: str) -> None:
        """So many shots of this step; refused ones are made again, and progress never falls."""
        made = len(job.result.steps)
        known = [planned.shots for planned in self._outline.steps[made : made + 1]]
        job.at(max(job.done, self._before + min([shots, *known])), phase)

    def _finish(self, job: ProcedureJob, series: StepSeries, ended: str) -> None:
        """Put the recording together, and say in it and in the log why the procedure ended."""
        job.at(job.done, "write")
        job.result = job.result.model_copy(update={"stopped": ended})
        made, planned = sum(step.complete for step in job.result.steps), len(self._outline.steps)
        try:
            series.finish("" if self._whole or made == planned else f"stopped after {made} of {planned} steps: {ended}")
        finally:
            series.close()
            self._keep_log(job)

    def _keep_log(self, job: ProcedureJob) -> None:
        """On disk before it continues.  Raises StorageError."""
        path = self._files.log or self._files.logs / f"{job.identifier}.json"
        write_file(path, to_json(self.record(job), indent=1).encode())


def _at(error: Exception, step: str) -> Exception:
    """The same error, naming the step."""
    if not isinstance(error, PlatformError):
        return error
    found = copy.copy(error)
    found.where = f"{step}: {error.where}" if error.where else step
    return found
