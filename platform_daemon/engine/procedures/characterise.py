"""Characterise: tune, a ramp, many shots at 80 % of what it found, and the paper's tables from the recording."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drivers.errors import PlatformError
from platform_daemon import analysis
from platform_daemon.schemas import (
    AcquisitionRequest,
    CharacteriseOutcome,
    CharacteriseRequest,
    ProcedureResult,
    ProcedureSummary,
)
from platform_daemon.workers import Computer, Stopped

from ..jobs import Cancelled
from ..work.characterisation import CharacterisationFiles, Tables, keep_tables
from .procedure import ProcedureJob, ShotFiles, Step, StepSequence
from .ramp import Ramp
from .tune import Tune

if TYPE_CHECKING:
    from platform_daemon.analysis import CharacterisationTask, NamedModel

_FITS_S = 1.0
"""About what both fits of a shot take, s."""


class NoFieldError(PlatformError):
    """A ramp has found no field to work at."""

    title = "No field to work at"


class Characterise:
    """See Procedure: tune and a ramp, if they are asked for, then the shots with what these have found.

    kept_t: field to work at that an earlier ramp has found, T; it counts where none is asked for.
    """

    title = "characterise"
    outcome = None  # before its conclusion

    def __init__(
        self, request: CharacteriseRequest, tune: Tune | None, ramp: Ramp | None, kept_t: float | None
    ) -> None:
        self.request, self.tune, self.ramp = request, tune, ramp
        self._tuned: dict[str, Any] = {}
        asked = request.acquisition.sequence.field_t
        self._field_t = kept_t if asked is None else asked
        self._shots = self._at(self._field_t)

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

    def _at(self, field_t: float | None) -> Step:
        """The shots at this field; None: what tune has found, else the preset's."""
        asked = self.request.acquisition
        keys = self._tuned | asked.sequence.changes() | ({} if field_t is None else {"field_t": field_t})
        return Step((), AcquisitionRequest.model_validate(asked.model_dump(exclude_none=True) | {"sequence": keys}))

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
            self._shots = self._at(self._field_t)
        if self.ramp is not None:
            if self._tuned:
                self.ramp.tuned(self._tuned)
            why = yield from self.ramp.steps()
            found = self.ramp.outcome
            if found is None or found.operating_field_t is None:
                raise NoFieldError("the ramp has found no field", why=why, remedy="look at its steps, and give a field")
            self._shots = self._at(found.operating_field_t)
        yield self._shots
        return "every shot was made"

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
    """Some shots of a recording, as what is to be characterised.  Made by whoever computes."""

    recording: Path
    model: NamedModel
    frames: tuple[int, ...]
    held: Mapping[str, float] | None
    alpha: float

    def __call__(self) -> CharacterisationTask:
        """Raises InputError, RecordingError."""
        settings = analysis.FitSettings(self.model.choice(), frames=self.frames)
        return analysis.characterisation_task(self.recording, settings, self.held, self.alpha)


@dataclass(frozen=True)
class CheckHeld:
    """Can these losses be held?  A task for whoever computes."""

    model: NamedModel
    held: Mapping[str, float]

    def __call__(self, tell: Callable[[float, str], None]) -> None:
        """Raises InputError."""
        analysis.check_held_in_n50(self.model.choice(), self.held)


@dataclass(frozen=True)
class CharacteriseConclusion:
    """See Conclusion: fits both windows of every shot and keeps tables and page.

    model: of the fits; procedure: with its ramp; computer: fits.
    """

    request: CharacteriseRequest
    model: NamedModel
    files: CharacterisationFiles | None
    procedure: Characterise
    computer: Computer

    def share(self, outline: ProcedureSummary) -> float:
        """See Conclusion."""
        fits_s = _FITS_S * outline.shots
        return fits_s / (fits_s + outline.duration_s)

    def __call__(self, job: ProcedureJob, recording: Path, tell: Callable[[str, float], None]) -> None:
        """See Conclusion."""
        frames = job.result.steps[-1].frames
        shots = RecordedShots(recording, self.model, frames, self.request.held_in_n50 or None, self.request.alpha)
        tables = Tables(shots, None if self.files is None else self.files.page)
        try:
            told = partial(_other_way_round, tell)
            report, page = self.computer.compute("procedure", tables, told, job.cancel_requested)
        except Stopped:
            raise Cancelled from None
        keep_tables(report, page, self.files, job)
        tell("write", 1.0)
        tune = None if self.procedure.tune is None else self.procedure.tune.outcome
        ramp = None if self.procedure.ramp is None else self.procedure.ramp.outcome
        outcome = CharacteriseOutcome(kind="characterise", tune=tune, ramp=ramp, report=report)
        job.result = job.result.model_copy(update={"outcome": outcome})


def _other_way_round(tell: Callable[[str, float], None], done: float, what: str) -> None:
    tell(what, done)
