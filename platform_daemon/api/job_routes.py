"""What every kind of job has: routes that list, get and cancel, a result or why there is none, perhaps a page."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from fastapi import APIRouter, Response

from drivers.errors import InputError
from platform_daemon.engine import UnknownId
from platform_daemon.link import ShownJob
from platform_daemon.schemas import NoResult, QueuedJob, Root, Schema

from .at_once import at_once
from .context import JobId, Shared
from .pages import NEXT, Paged
from .problems import problem, problems
from .ranged_file import RangedFile, ranged

JobT = TypeVar("JobT", bound=Schema)
PAGE = {**ranged({"text/html": {"schema": {"type": "string"}}}), **problems(404, 422)}
"""What a route declares that answers with a page."""


@dataclass(frozen=True)
class JobKind(Generic[JobT]):
    """A kind of job as the API shows it.

    Attributes:
        name: kind of the engine's jobs; plural: of the path and of the routes' names.
        body, listing: schema of one job and of all.
        links: paths beside its own.
        got, cancelled: what GET and DELETE bring, in words.
    """

    name: str
    plural: str
    body: type[JobT]
    listing: type[Root[Any]]
    links: Callable[[ShownJob], dict[str, str]]
    got: str
    cancelled: str

    def shown(self, job: ShownJob) -> JobT:
        """The job as it is now."""
        links = {"self": f"/{self.plural}/{job.identifier}", **self.links(job)}
        parts = {
            "id": job.identifier,
            "kind": job.kind,
            "state": job.state,
            "progress": job.progress,
            "created": job.record.times.created,
            "started": job.record.times.started,
            "finished": job.record.times.finished,
            "request": job.request,
            "result": job.result,
            "warnings": job.record.warnings,
            "error": None if job.error is None else problem(job.error, links["self"]),
            "links": links,
        }
        if issubclass(self.body, QueuedJob):
            parts["priority"] = job.request.priority
        if self.name == "calibration":
            parts["question"] = job.question
        if self.name == "procedure":
            parts["paused"] = job.paused
        return self.body(**parts)

    def accepted(self, job: ShownJob, response: Response) -> JobT:
        """The answer to what began it."""
        response.headers["Location"] = f"/{self.plural}/{job.identifier}"
        return self.shown(job)

    def add_routes(self, router: APIRouter) -> None:
        """GET all, GET one, DELETE one."""

        def list_jobs(context: Shared, page: Paged) -> Any:
            holder = context.holder(self.name)
            here = tuple(page.of(holder.job_ids(self.name)))
            return page.as_json((job.identifier, self.shown(job)) for job in holder.jobs(self.name, here))

        def get_job(identifier: JobId, context: Shared) -> Any:
            return self.shown(context.holder(self.name).job(self.name, identifier))

        async def cancel_job(identifier: JobId, context: Shared) -> Any:
            holder = context.holder(self.name)
            # It writes the job's record, and waits for the disk.
            return self.shown(await at_once(lambda: holder.cancel(self.name, identifier)))

        router.add_api_route(
            "",
            list_jobs,
            name=f"list_{self.plural.replace('-', '_')}",
            summary=f"All {self.plural}",
            description=f"All {self.plural} since the daemon's data folder began, oldest first, page by page.",
            response_model=self.listing,
            responses={**NEXT, **problems(422)},
        )
        router.add_api_route(
            "/{identifier}",
            get_job,
            name=f"get_{self.name}",
            summary="How far it is, and what came out",
            description=self.got,
            response_model=self.body,
            responses=problems(404),
        )
        router.add_api_route(
            "/{identifier}",
            cancel_job,
            methods=["DELETE"],
            name=f"cancel_{self.name}",
            summary="Cancel",
            description=self.cancelled,
            status_code=202,
            response_model=self.body,
            responses=problems(404, 415),
        )


def result_of(job: ShownJob, again: str) -> Any:
    """What came out.  Raises InputError if nothing has; again: what to do where nothing will, as "fit anew"."""
    if not isinstance(job.result, NoResult):
        return job.result
    why = f"it is {job.state}" + (f": {job.error}" if job.error is not None else "")
    remedy = f"remove the cause and {again}" if job.state.final else "wait until its state is done"
    raise InputError(f"the {job.kind} has no result", where=job.identifier, why=why, remedy=remedy)


def page_of(job: ShownJob, folder: Path, again: str) -> RangedFile:
    """The page that a job has made.  Raises InputError if it has no result, UnknownId if the page is gone."""
    result_of(job, again)
    page = folder / f"{job.identifier}.html"
    if not page.is_file():
        raise UnknownId("the page is not there any more", where=job.identifier, remedy=again)
    return RangedFile(page, "text/html")
