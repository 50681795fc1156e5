"""The job of a campaign: both resonators one after the other, each a procedure of its own, and the report."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drivers.errors import InputError
from platform_daemon import __version__
from platform_daemon.core.jobs.jobs import AnyJob, Cancelled, Job
from platform_daemon.core.jobs.run_task import run_task
from platform_daemon.core.schemas.base import NoResult
from platform_daemon.core.service.bench import HardwareBench
from platform_daemon.features.procedures.bench import ProcedureBench
from platform_daemon.features.procedures.conductor import ProcedureFiles, ProcedureWork
from platform_daemon.features.procedures.planned import plan_procedure

from .campaign import characterise_request, draws_of, held_in_n50, is_measured, report_files
from .schema import Campaign, Claims, ReproductionRequest

_CONCLUSION = 0.2  # of the time that a campaign takes


@dataclass
class _Part(Job[Any, Any]):
    """One resonator's procedure.  Its steps are steps of the campaign, whose id and events it has."""

    whole: AnyJob | None = None
    begins: float = 0.0
    share: float = 1.0

    @property
    def priority(self) -> int:
        """Of the campaign."""
        assert self.whole is not None
        return self.whole.priority

    def rest(self, longest_s: float) -> bool:
        """Wait as the campaign, whose phase and pace say so."""
        assert self.whole is not None
        return self.whole.rest(longest_s)

    def at(self, done: float, phase: str) -> None:
        """Report progress, also as that of the campaign."""
        super().at(done, phase)
        assert self.whole is not None
        self.whole.at(self.begins + self.share * min(1.0, done / self.total), phase)


@dataclass
class ReproductionWork:
    """See Work.

    bench: of the daemon; campaign: what is measured of each; planned: works of the resonators, checked when the job was
    submitted.  Measured is by others that are planned when their turn comes: the jewel's fits hold what the thread's
    have found.
    """

    request: ReproductionRequest
    bench: HardwareBench
    campaign: Campaign
    planned: dict[str, ProcedureWork]
    kind, unit, total, no_result = "reproduction", "share", 1.0, NoResult()

    @property
    def duration_s(self) -> float:
        """See Work."""
        return sum(work.duration_s for work in self.planned.values())

    def __call__(self, job: AnyJob) -> None:
        """Raises Cancelled, what ends a procedure, what a task raises, StorageError."""
        folder = self.bench.folders.reproductions / job.identifier
        folder.mkdir(parents=True, exist_ok=True)
        begins = 0.0
        for variant, resonator in self.request.resonators.items():
            share = (1.0 - _CONCLUSION) * self.planned[variant].duration_s / self.duration_s
            if not is_measured(folder, variant, resonator):
                self._measure(job, folder, variant, begins, share)
            begins += share
            job.at(begins, f"{variant}: done")
        task = Concluded(folder, draws_of(self.campaign.shots), begins)
        job.result = run_task(self.bench.engine.computing, self.kind, task, job)
        job.at(self.total, "write")

    def _measure(self, job: AnyJob, folder: Path, variant: str, begins: float, share: float) -> None:
        work = _planned(self.bench, self.campaign, folder, variant, self.request.resonators[variant])
        part = _Part(
            work.kind, work.request, work.no_result, work.total, work.unit, identifier=job.identifier,
            whole=job, begins=begins, share=share,
        )  # fmt: skip
        part.cancel_requested, part.pause_requested = job.cancel_requested, job.pause_requested
        if not part.begin():
            raise Cancelled
        try:
            work(part)
        finally:
            job.warnings += [f"{variant}: {text}" for text in part.warnings]


@dataclass(frozen=True)
class Concluded:
    """Noise sweep, claims and report.  A task of the task executor.

    folder: of the campaign; draws: of noise for each shot and level; begins: share of the job that is done before.
    """

    folder: Path
    draws: int
    begins: float

    def __call__(self, tell: Callable[[float, str], None]) -> Claims:
        """Raises PlatformError."""
        from platform_daemon.features.fit.batch.executors import in_this_process

        from .conclusion import conclude

        left = 0.9 * (1.0 - self.begins)  # the last tenth is the report
        return conclude(
            self.folder, self.draws, in_this_process(), lambda what, share: tell(self.begins + left * share, what)
        )


def _planned(bench: HardwareBench, campaign: Campaign, folder: Path, variant: str, resonator: str) -> ProcedureWork:
    """Raises InputError."""
    recording = folder / f"{variant}.h5"
    log = recording.with_name(f"{recording.name}.log.json")
    files = ProcedureFiles(folder, folder, recording, log, overwrite=True)  # what is there is not whole
    request = characterise_request(campaign, variant, resonator, held_in_n50(folder, variant))
    return plan_procedure(ProcedureBench(engine=bench.engine, files=files, reports=report_files(recording)), request)


def plan(bench: HardwareBench, request: ReproductionRequest) -> ReproductionWork:
    """The work of a campaign, every known step of it checked.

    Raises InputError, also for two resonators on a platform that does not change them itself; StorageUnusable,
    InterlockError.
    """
    if len(request.resonators) > 1 and not bench.engine.platform.changes_resonators:
        raise InputError(
            "the platform holds one resonator at a time",
            where="thread, jewel",
            remedy="ask for one, with null for the other; `platform-daemon reproduce` measures one after the other "
            "into one folder",
        )
    campaign = request.campaign(__version__)
    for resonator in request.resonators.values():
        bench.engine.catalogue.resonators.named(resonator)
    again = "" if bench.again is None else bench.again.identifier
    folder = bench.folders.reproductions / again
    planned = {v: _planned(bench, campaign, folder, v, name) for v, name in request.resonators.items()}
    outlines = [work.summary() for work in planned.values()]
    bench.check_feasible(sum(each.disk_bytes for each in outlines), sum(each.shots for each in outlines))
    return ReproductionWork(request, bench, campaign, planned)
