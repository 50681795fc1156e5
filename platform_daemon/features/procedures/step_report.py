"""What a step has brought, from the jobs that made it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from statistics import median, stdev

from platform_daemon.core.schemas.fits import BLANK, FrameFit
from platform_daemon.features.acquire.work import AcquisitionJob

from .procedure import Fits, Step
from .schema import StepEstimate, StepReport

QUALITIES = ("r2", "nrmse", "chi2_per_dof")
"""Results of a fit other than its parameters."""


@dataclass
class StepAttempts:
    """The jobs of one step so far: a first one, and those that repeat refused shots or continue after a pause.

    first_frame: number of its first frame in the recording, from 0.
    """

    number: int
    step: Step
    first_frame: int
    began: datetime
    jobs: list[AcquisitionJob] = field(default_factory=list)
    refusals: int = 0  # attempts with refused shots

    def add(self, job: AcquisitionJob) -> None:
        """A job that has ended."""
        self.jobs.append(job)
        self.refusals += bool(job.result.refused)

    @property
    def shots(self) -> int:
        """Shots on disk."""
        return sum(job.result.shots or 0 for job in self.jobs)

    @property
    def refused(self) -> int:
        """Excited shots that were refused."""
        return sum(job.result.refused or 0 for job in self.jobs)

    @property
    def left(self) -> tuple[int, int]:
        """(excited, blank) shots that are still to be made; a refused blank shot is not made again."""
        acquisition = self.step.acquisition
        blank = sum(min(job.result.shots or 0, job.request.blank_shots) for job in self.jobs)
        return acquisition.shots - (self.shots - blank - self.refused), acquisition.blank_shots - blank

    def report(self, fits: Fits, ended: datetime, last_shot: Path) -> StepReport:
        """What the step has brought; last_shot: the file of its last shot."""
        near_hz = self.step.listen_near_hz
        found = [report for job in self.jobs if (report := fits.of(job.result)) is not None]
        frames = [frame for report in found for frame in report.frames]
        good = [frame for frame in frames if frame.good]
        usable = len(good) if frames else self.shots - self.refused
        return StepReport(
            step=self.number,
            values=self.step.values,
            complete=max(self.left) <= 0,
            verdict="good" if usable else "refused",
            reason=None if usable else _reason(frames),
            frames=tuple(range(self.first_frame, self.first_frame + self.shots)),
            refused=self.refused,
            fitted=len(good),
            heard=None if near_hz is None else fits.ringing(last_shot, near_hz),
            results=_results(good),
            acquisitions=tuple(job.identifier for job in self.jobs),
            warnings=tuple(dict.fromkeys(text for job in self.jobs for text in job.warnings)),
            started=self.began.isoformat(),
            seconds=(ended - self.began).total_seconds(),
            value_sources=self.jobs[-1].result.value_sources,
        )


def _reason(frames: Sequence[FrameFit]) -> str:
    return next((f.reason for f in frames if f.reason and f.reason != BLANK), "no shot was made")


def _results(good: Sequence[FrameFit]) -> dict[str, StepEstimate]:
    """Medians over the good fits, of what all of them have."""
    names = [name for name in (good[0].parameters if good else ()) if all(name in f.parameters for f in good)]
    found = {n: _estimate([f.parameters[n].value for f in good], [f.parameters[n].std for f in good]) for n in names}
    for name in QUALITIES:
        values = [value for f in good if (value := getattr(f, name)) is not None]
        found |= {name: _estimate(values, [None])} if values else {}
    return found


def _estimate(values: Sequence[float], stds: Sequence[float | None]) -> StepEstimate:
    known = [std for std in stds if std is not None]
    return StepEstimate(
        median=median(values),
        scatter=stdev(values) if len(values) > 1 else None,
        std=median(known) if known else None,
    )
