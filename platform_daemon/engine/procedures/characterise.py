"""Characterise: a ramp, many shots at 80 % of what it found, and the paper's tables from the recording."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from drivers.errors import PlatformError
from platform_daemon import analysis
from platform_daemon.schemas import CharacteriseOutcome, CharacteriseRequest, ProcedureResult, ProcedureSummary

from ..work.characterisation import CharacterisationFiles, characterise_to_disk
from .procedure import ProcedureJob, ShotFiles, Step, StepSequence
from .ramp import Ramp

if TYPE_CHECKING:
    from platform_daemon.analysis import ModelChoice

_FITS_S = 1.0
"""About what both fits of a shot take, s."""


class NoFieldError(PlatformError):
    """A ramp has found no field to work at."""

    title = "No field to work at"


class Characterise:
    """See Procedure: a ramp, if there is one, then the shots at the field that it found.

    kept_t: field to work at that an earlier ramp has found, T; it counts where none is asked for.
    """

    title = "characterise"
    outcome = None  # before its conclusion

    def __init__(self, request: CharacteriseRequest, ramp: Ramp | None, kept_t: float | None) -> None:
        self.request, self.ramp = request, ramp
        asked = request.acquisition.sequence.field_t
        self._shots = self._at(kept_t if asked is None and kept_t is not None else asked)

    @property
    def ends_early(self) -> str | None:
        """See Procedure."""
        return None if self.ramp is None else f"its ramp ends when {self.ramp.ends_early}"

    @property
    def open_ended(self) -> bool:
        """See Procedure."""
        return self.ramp is not None

    def _at(self, field_t: float | None) -> Step:
        """The shots at this field; None: the preset's."""
        made = self.request.acquisition
        if field_t is not None:
            made = made.model_copy(update={"sequence": made.sequence.model_copy(update={"field_t": field_t})})
        return Step((), made)

    def outline(self) -> Sequence[Step]:
        """See Procedure."""
        return [*(() if self.ramp is None else self.ramp.outline()), self._shots]

    def steps(self) -> StepSequence:
        """See Procedure.  Raises what a ramp raises, NoFieldError."""
        if self.ramp is not None:
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
        if self.ramp is not None:
            self.ramp.conclude(job, result)


@dataclass(frozen=True)
class CharacteriseConclusion:
    """See Conclusion: fits both windows of every shot and keeps tables and page.

    model: of the fits, None: what the recording says; procedure: with its ramp.
    """

    request: CharacteriseRequest
    model: ModelChoice | None
    files: CharacterisationFiles | None
    procedure: Characterise

    def share(self, outline: ProcedureSummary) -> float:
        """See Conclusion."""
        fits_s = _FITS_S * outline.shots
        return fits_s / (fits_s + outline.duration_s)

    def __call__(self, job: ProcedureJob, recording: Path, tell: Callable[[str, float], None]) -> None:
        """See Conclusion."""
        frames = job.result.steps[-1].frames
        settings = analysis.FitSettings(self.model, frames=frames)
        held = self.request.held_in_n50 or None
        task = analysis.characterisation_task(recording, settings, held, self.request.alpha)
        report = characterise_to_disk(task, self.files, job, tell)
        ramp = None if self.procedure.ramp is None else self.procedure.ramp.outcome
        outcome = CharacteriseOutcome(kind="characterise", ramp=ramp, report=report)
        job.result = job.result.model_copy(update={"outcome": outcome})
