"""Characterise: tune, a ramp, many shots at 80 % of what it found, and the paper's tables from the recording."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drivers.errors import PlatformError
from platform_daemon.core.jobs.jobs import Cancelled
from platform_daemon.core.jobs.run_task import run_task_with_retry
from platform_daemon.core.jobs.workers.bounds import TaskCancelled
from platform_daemon.core.jobs.workers.task_executor import TaskExecutor
from platform_daemon.core.recordings.added_fits import add_fit
from platform_daemon.core.recordings.fit_joining import NOT_FITTED
from platform_daemon.core.recordings.header import FitTable
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.schemas.fits import unfitted
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.core.schemas.value_sources import PROCEDURE, Origin
from platform_daemon.core.state.errors import StorageError
from platform_daemon.features.fit.series_table import fit_table
from platform_daemon.features.procedures.bench import ProcedureBench, ReportFiles
from platform_daemon.features.procedures.conductor import ProcedureWork
from platform_daemon.features.procedures.procedure import ProcedureJob, ShotFiles, Step, StepSequence
from platform_daemon.features.procedures.schema import ProcedureResult, ProcedureSummary
from platform_daemon.features.ramp.work import Ramp, ramp_of
from platform_daemon.features.tune.work import FOUND_KEYS, Tune, tune_of

from .schema import CharacterisationReport, CharacteriseOutcome, CharacteriseRequest
from .tables_work import Tables, keep_tables

if TYPE_CHECKING:
    from platform_daemon.features.fit.online import NamedModel
    from platform_daemon.features.ramp.schema import RampOutcome

    from .tables import CharacterisationTask

N50_FITS = "n50_characterise"
"""Name of the N50 fits in the recording: on-line fits may be `n50`, and hold nothing."""
_FITS_S = 1.0
"""About what both fits of a shot take, s."""


class NoFieldError(PlatformError):
    """A ramp has found no field to work at."""

    title = "No field to work at"


class Characterise:
    """See Procedure: tune and a ramp, if they are requested, then the shots with what these have found.

    kept_t, kept_from: field to work at that an earlier ramp has found, T, and which ramp; it counts where none is
    requested.  preset_t: field of the preset, T.
    """

    title = "characterise"
    outcome = None  # before its conclusion

    def __init__(
        self, request: CharacteriseRequest, tune: Tune | None, ramp: Ramp | None, *, kept_t: float | None,
        kept_from: Origin | None, preset_t: float,
    ) -> None:  # fmt: skip
        self.request, self.tune, self.ramp = request, tune, ramp
        self._kept_t, self._preset_t = kept_t, preset_t
        self.remarks: tuple[str, ...] = ()
        """What is to be known of the shots, in words."""
        self._tuned: dict[str, Any] = {}
        requested_t = request.acquisition.sequence.field_t
        self._field_t = kept_t if requested_t is None else requested_t
        self._field_from = None if requested_t is not None or kept_t is None else kept_from
        self._shots = self._at(self._field_t, self._field_from if ramp is None else PROCEDURE)

    @property
    def ends_early(self) -> str | None:
        """See Procedure."""
        ends = [] if self.tune is None else [f"tune ends when {self.tune.ends_early}"]
        ends += [] if self.ramp is None else [f"the ramp ends when {self.ramp.ends_early}"]
        return "; ".join(ends) or None

    @property
    def open_ended(self) -> bool:
        """See Procedure."""
        return self.tune is not None or self.ramp is not None

    def _at(self, field_t: float | None, field_from: Origin | None = None) -> Step:
        """The shots at this field, which comes from there, None: from the request.  field_t None: what tune has found,
        else the preset's.
        """
        acquisition = self.request.acquisition
        given = acquisition.sequence.changes()
        keys = self._tuned | given | ({} if field_t is None else {"field_t": field_t})
        origins = {key: Origin("tuned") for key in self._tuned if key not in given}
        if self.tune is not None and not self._tuned:  # what is planned with until it has found its own
            origins = {key: PROCEDURE for key in FOUND_KEYS if key not in given}
        if field_from is not None:
            origins["field_t"] = field_from
        elif field_t is not None:
            origins.pop("field_t", None)
        made = AcquisitionRequest.model_validate(acquisition.model_dump(exclude_none=True) | {"sequence": keys})
        return Step((), made, origins=origins, name="series")

    def outline(self) -> Sequence[Step]:
        """See Procedure."""
        before = [step for each in (self.tune, self.ramp) if each is not None for step in each.outline()]
        return [*before, self._shots]

    def steps(self) -> StepSequence:
        """See Procedure.  Raises what tune and a ramp raise, NoFieldError."""
        if self.tune is not None:
            yield from self.tune.steps()
            sequence = self.tune.outcome.sequence
            assert sequence is not None
            self._tuned = sequence.changes()
            self._shots = self._at(self._field_t, self._field_from)
        if self.ramp is not None:
            if self._tuned:
                self.ramp.tuned(self._tuned)
            why = yield from self.ramp.steps()
            found = self.ramp.outcome
            if found is None or found.ended_by == "first_field":
                raise NoFieldError("the ramp has found no field", why=why, remedy="look at its steps, and give a field")
            if found.operating_field_t is None:
                self._shots = self._without_threshold(found, why)
            else:
                self._shots = self._at(found.operating_field_t, Origin("ramp"))
        yield self._shots
        return "every shot was made"

    def _without_threshold(self, found: RampOutcome, why: str) -> Step:
        """The shots after a ramp that has found no threshold: in the field that they would have without a ramp, but not
        above the highest that the ramp has tried.
        """
        requested_t = self.request.acquisition.sequence.field_t
        name = "the field that was requested" if requested_t is not None else "the preset's field"
        if requested_t is None and self._kept_t is not None:
            name = "the field that an earlier ramp has kept"
        field_t = float(self._field_t or self._tuned.get("field_t", self._preset_t))
        said = f"the shots are made in {name}, {1e6 * field_t:.4g} uT"
        highest_t, shots = found.highest_field_t or field_t, self._shots
        if field_t > highest_t * (1.0 + 1e-9):
            said = (
                f"the shots are made at {1e6 * highest_t:.4g} uT, the highest field of the ramp: {name}, "
                f"{1e6 * field_t:.4g} uT, lies above it"
            )
            shots = self._at(highest_t, PROCEDURE)
        self.remarks = (f"{why}; no threshold was found, and {said}",)
        return shots

    def reads(self, files: ShotFiles) -> None:
        """See ReadsShots."""
        if self.ramp is not None:
            self.ramp.reads(files)

    def conclude(self, job: str, result: ProcedureResult) -> None:
        """See Procedure."""
        for each in (self.tune, self.ramp):
            if each is not None:
                each.conclude(job, result)


@dataclass(frozen=True)
class RecordedShots:
    """Some shots of a recording, as what is to be characterised.  Made by the task executor."""

    recording: Path
    model: NamedModel
    frames: tuple[int, ...]
    held: Mapping[str, float] | None
    alpha: float
    remarks: tuple[str, ...] = ()

    def __call__(self) -> CharacterisationTask:
        """Raises InputError, RecordingError."""
        from platform_daemon.features.fit.fit_request import FitSettings

        from .tables import characterisation_task

        settings = FitSettings(self.model.choice(), frames=self.frames)
        task = characterisation_task(self.recording, settings, self.held, self.alpha)
        return replace(task, remarks=(*task.remarks, *self.remarks))


@dataclass(frozen=True)
class CheckHeld:
    """Can these losses be held?  A task of the task executor."""

    model: NamedModel
    held: Mapping[str, float]

    def __call__(self, tell: Callable[[float, str], None]) -> None:
        """Raises InputError."""
        from .tables import check_held_in_n50

        check_held_in_n50(self.model.choice(), self.held)


@dataclass(frozen=True)
class CharacteriseConclusion:
    """See Conclusion: fits both windows of every shot and keeps tables and page.

    model: of the fits; procedure: with its ramp; executor: fits.
    """

    request: CharacteriseRequest
    model: NamedModel
    files: ReportFiles | None
    procedure: Characterise
    executor: TaskExecutor

    def share(self, outline: ProcedureSummary) -> float:
        """See Conclusion."""
        fits_s = _FITS_S * outline.shots
        return fits_s / (fits_s + outline.duration_s)

    def __call__(self, job: ProcedureJob, recording: Path, tell: Callable[[str, float], None]) -> None:
        """See Conclusion."""
        frames = job.result.steps[-1].frames
        remarks = self.procedure.remarks
        job.warnings += remarks
        held = self.request.held_in_n50 or None
        shots = RecordedShots(recording, self.model, frames, held, self.request.alpha, remarks)
        tables = Tables(shots, with_page=self.files is not None)
        try:
            report_progress = partial(_other_way_round, tell)
            report, page = self.executor.run("procedure", tables, report_progress, job.cancel_requested)
        except TaskCancelled:
            raise Cancelled from None
        keep_tables(report, page, self.files, job)
        try:
            add_fit(recording, short_fits(report, open_recording(recording).frames))
        except StorageError as error:  # the recording is as it was, and the report has the same numbers
            job.warnings.append(f"the N50 fits are not in the recording: {error}")
        tell("write", 1.0)
        tune = None if self.procedure.tune is None else self.procedure.tune.outcome
        ramp = None if self.procedure.ramp is None else self.procedure.ramp.outcome
        outcome = CharacteriseOutcome(kind="characterise", tune=tune, ramp=ramp, report=report)
        job.result = job.result.model_copy(update={"outcome": outcome})


def short_fits(report: CharacterisationReport, frames: int) -> FitTable:
    """The N50 fits as a recording of so many frames keeps them; frames before the shots are refused."""
    fits = [unfitted(k, NOT_FITTED) for k in range(frames)]
    for fit in report.n50_fits.frames:
        fits[fit.frame] = fit
    return fit_table(N50_FITS, report.variant, fits)


def _other_way_round(tell: Callable[[str, float], None], done: float, what: str) -> None:
    tell(what, done)


def plan(bench: ProcedureBench, request: CharacteriseRequest) -> ProcedureWork:
    """After tune and a ramp, if requested; otherwise at the field that an earlier ramp stored with the specimen.

    Raises InputError.
    """
    engine = bench.engine
    planned = bench.plan_series(request.acquisition)
    run_task_with_retry(engine.online, "planning", CheckHeld(planned.model, request.held_in_n50))
    tune = tune_of(bench, request.tune_request()) if request.tune else None
    ramp = None if request.ramp is None else ramp_of(bench, request.ramp_request())
    kept = planned.specimen.side_modes
    kept_t = None if kept is None else kept.operating_field_t
    limits = [each for each in planned.value_sources if each.quantity == "max_field_t"]
    kept_from = next((Origin(each.source, each.job, each.date, each.path) for each in limits), None)
    procedure = Characterise(request, tune, ramp, kept_t=kept_t, kept_from=kept_from, preset_t=planned.sequence.field_t)
    conclusion = CharacteriseConclusion(request, planned.model, bench.reports, procedure, engine.computing)
    return bench.work(procedure, conclusion)
