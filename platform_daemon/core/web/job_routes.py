"""What every kind of job has: routes that start, edit, list, get and cancel; a result, or why there is none; a page."""

from __future__ import annotations

from collections.abc import Callable
from inspect import cleandoc
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter, Header, Response

from drivers.errors import InputError
from platform_daemon.core.jobs.job_registry import UnknownId
from platform_daemon.core.jobs.kinds import job_list_type, job_type
from platform_daemon.core.registry import feature_of
from platform_daemon.core.schemas.base import NoResult
from platform_daemon.core.service.job_view import JobView
from platform_daemon.core.service.submit_once import MOST_KEY

from .context import CONFIRMED, Confirmed, JobId, Shared
from .network.routes import GuardedRoute
from .own_thread import run_in_own_thread
from .pages import NEXT, Paged
from .problems import OWNER, problem, problems
from .ranged_file import RangedFile, ranged

PAGE = {**ranged({"text/html": {"schema": {"type": "string"}}}), **problems(404, 422)}
"""What a route declares that answers with a page."""


IdempotencyKey = Annotated[
    str | None,
    Header(
        alias="Idempotency-Key",
        min_length=1,
        max_length=MOST_KEY,
        description="any text that is new for each job, as a UUID: a request that is repeated with it starts no second "
        "job, but returns the first one, also after a restart of the daemon",
    ),
]
Links = Callable[[JobView], dict[str, str]]
"""Paths next to a job's own, by what is there."""


class JobRoutes:
    """The standard routes of a kind of job: start, edit, list, get, cancel.

    kind: of a feature of the registry; links: paths next to its own.
    """

    def __init__(self, kind: str, links: Links = lambda job: {}) -> None:
        self.kind = feature_of(kind).kind
        self._links = links
        self._job: type[Any] = job_type(kind)

    def router(self) -> APIRouter:
        """The router of the feature, with the standard routes."""
        kind = self.kind
        made = APIRouter(
            prefix=f"/{kind.plural}",
            tags=[kind.plural],
            route_class=GuardedRoute,
            responses=problems(*OWNER) if kind.needs_hardware else {},
        )
        self._add_start(made)
        if kind.needs_hardware:
            self._add_edit(made)
        return made

    def shown(self, job: JobView) -> Any:
        """The job as REST shows it."""
        links = {"self": f"/{self.kind.plural}/{job.identifier}", **self._links(job)}
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
        known = {
            "priority": getattr(job.request, "priority", 0),
            "clock": job.record.clock,
            "question": job.question,
            "paused": job.paused,
        }
        return self._job(**parts, **{name: value for name, value in known.items() if name in self._job.model_fields})

    def _add_start(self, router: APIRouter) -> None:
        def start(body: Any, response: Response, context: Shared, key: IdempotencyKey = None) -> Any:
            service = context.jobs_of(self.kind.name)
            if key is None:
                job = service.submit(self.kind.name, body)
            else:
                job = service.submit_once(self.kind.name, body, key)
            response.headers["Location"] = f"/{self.kind.plural}/{job.identifier}"
            return self.shown(job)

        start.__annotations__["body"] = feature_of(self.kind.name).request_type
        router.add_api_route(
            "",
            start,
            methods=["POST"],
            name=f"start_{self.kind.name}",
            summary=self.kind.title,
            description=cleandoc(self.kind.about),
            status_code=202,
            response_model=self._job,
            responses=problems(409, 415, 422, 423, 507)
            if self.kind.needs_hardware
            else problems(404, 415, 422, 423, 503, 507),
        )

    def _add_edit(self, router: APIRouter) -> None:
        name = self.kind.name

        def edit(identifier: JobId, body: Any, context: Shared) -> Any:
            return self.shown(context.hardware.edit(name, identifier, body))

        edit.__annotations__["body"] = feature_of(name).request_type
        what = f"{'an' if name[0] in 'aeiou' else 'a'} {name.replace('_', '-')}"
        router.add_api_route(
            "/{identifier}",
            edit,
            methods=["PUT"],
            name=f"edit_{name}",
            summary="Change what has not begun",
            description=f"Another request in the place of that of {what} that waits; 409 once it has begun.",
            response_model=self._job,
            responses=problems(404, 409, 415, 422, 507),
        )

    def add_pause_routes(self, router: APIRouter, *, ends: str, resume: tuple[str, str], cut_off: bool = False) -> None:
        """Pause and resume, of jobs that last long.

        ends: when a pause ends the job; resume: summary and description of going on; cut_off: one that has ended early
        is resumed, too, which may find its files in use or the disk full.
        """
        name = self.kind.name
        refused = problems(404, 409, 415, 422)

        def pause(identifier: JobId, context: Shared, body: Confirmed = CONFIRMED) -> Any:
            return self.shown(context.hardware.pause(name, identifier))

        def go_on(identifier: JobId, context: Shared, body: Confirmed = CONFIRMED) -> Any:
            return self.shown(context.hardware.resume(name, identifier))

        router.add_api_route(
            "/{identifier}/pause",
            pause,
            methods=["POST"],
            name=f"pause_{name}",
            summary="Rest at the next safe point",
            description="Rest after the shot under way, with outputs off, until it is resumed; other jobs run "
            f"meanwhile.\n\n{ends}",
            status_code=202,
            response_model=self._job,
            responses=refused,
        )
        summary, description = resume
        router.add_api_route(
            "/{identifier}/resume",
            go_on,
            methods=["POST"],
            name=f"resume_{name}",
            summary=summary,
            description=description,
            status_code=202,
            response_model=self._job,
            responses={**refused, **problems(423, 507)} if cut_off else refused,
        )

    def add_job_routes(self, router: APIRouter) -> None:
        """GET all, GET one, DELETE one; added last, for "/{identifier}" takes what no other route does."""
        name, plural = self.kind.name, self.kind.plural

        def list_jobs(context: Shared, page: Paged) -> Any:
            service = context.jobs_of(name)
            here = tuple(page.of(service.job_ids(name)))
            return page.as_json((job.identifier, self.shown(job)) for job in service.jobs(name, here))

        def get_job(identifier: JobId, context: Shared) -> Any:
            return self.shown(context.jobs_of(name).job(name, identifier))

        async def cancel_job(identifier: JobId, context: Shared) -> Any:
            service = context.jobs_of(name)
            # It writes the job's record, and waits for the disk.
            return self.shown(await run_in_own_thread(lambda: service.cancel(name, identifier)))

        router.add_api_route(
            "",
            list_jobs,
            name=f"list_{plural.replace('-', '_')}",
            summary=f"All {plural}",
            description=f"All {plural} since the daemon's data folder began, oldest first, page by page.",
            response_model=job_list_type(name),
            responses={**NEXT, **problems(422)},
        )
        router.add_api_route(
            "/{identifier}",
            get_job,
            name=f"get_{name}",
            summary="How far it is, and what came out",
            description=self.kind.got,
            response_model=self._job,
            responses=problems(404),
        )
        router.add_api_route(
            "/{identifier}",
            cancel_job,
            methods=["DELETE"],
            name=f"cancel_{name}",
            summary="Cancel",
            description=self.kind.cancelled,
            status_code=202,
            response_model=self._job,
            responses=problems(404, 415),
        )


def standard_router(kind: str) -> APIRouter:
    """All routes of a feature that has none of its own."""
    routes = JobRoutes(kind)
    router = routes.router()
    routes.add_job_routes(router)
    return router


def result_of(job: JobView, again: str) -> Any:
    """The result of a job.  again: the remedy for a job that has ended without one, as "submit a new fit".

    Raises InputError if there is no result.
    """
    if not isinstance(job.result, NoResult):
        return job.result
    why = f"it is {job.state}" + (f": {job.error}" if job.error is not None else "")
    remedy = f"remove the cause and {again}" if job.state.final else "wait until its state is done"
    raise InputError(f"the {job.kind} has no result", where=job.identifier, why=why, remedy=remedy)


def page_of(job: JobView, folder: Path, again: str) -> RangedFile:
    """The page that a job has made.  Raises InputError if it has no result, UnknownId if the page no longer exists."""
    result_of(job, again)
    page = folder / f"{job.identifier}.html"
    if not page.is_file():
        raise UnknownId("the page is not there any more", where=job.identifier, remedy=again)
    return RangedFile(page, "text/html")
