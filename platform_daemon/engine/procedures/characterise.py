"""Characterise: many shots of one resonator, and the paper's tables from its recording."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from platform_daemon import analysis
from platform_daemon.schemas import CharacteriseOutcome, CharacteriseRequest, ProcedureSummary

from ..work.characterisation import CharacterisationFiles, characterise_to_disk
from .procedure import ProcedureJob, Step, StepSequence

if TYPE_CHECKING:
    from platform_daemon.analysis import ModelChoice

_FITS_S = 1.0
"""About what both fits of a shot take, s."""


class Characterise:
    """See Procedure: one step, the shots."""

    title = "characterise"
    ends_early = None
    outcome = None  # before its conclusion

    def __init__(self, request: CharacteriseRequest) -> None:
        self.request = request
        self._shots = Step((), request.acquisition)

    def outline(self) -> Sequence[Step]:
        """See Procedure."""
        return [self._shots]

    def steps(self) -> StepSequence:
        """See Procedure."""
        yield self._shots
        return "every shot was made"


@dataclass(frozen=True)
class CharacteriseConclusion:
    """See Conclusion: fits both windows of every shot and keeps tables and page.

    model: of the fits, None: what the recording says.
    """

    request: CharacteriseRequest
    model: ModelChoice | None
    files: CharacterisationFiles | None

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
        outcome = CharacteriseOutcome(kind="characterise", report=report)
        job.result = job.result.model_copy(update={"outcome": outcome})
