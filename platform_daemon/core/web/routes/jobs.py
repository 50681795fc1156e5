"""Jobs of all kinds in one list, newest first."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from itertools import islice
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request, Response

from drivers.errors import InputError
from platform_daemon.core.registry import feature_of, job_features
from platform_daemon.core.schemas.job_list import JobListing, JobSummary
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.service.job_view import JobView
from platform_daemon.core.web.context import Context, Shared
from platform_daemon.core.web.network.routes import GuardedRoute
from platform_daemon.core.web.pages import NEXT, After, Page, requested_page
from platform_daemon.core.web.problems import OWNER, problems

router = APIRouter(prefix="/jobs", tags=["jobs"], route_class=GuardedRoute)
_CREATED = re.compile(r"\d{8}T\d{6}")
_AT_ONCE = 20  # jobs that are read together; each may hold the fits of all its shots
States = Annotated[list[JobState] | None, Query(max_length=5, description="only these; may be repeated")]
Kinds = Annotated[list[str] | None, Query(max_length=20, description="only these kinds; may be repeated")]
Limit = Annotated[int, Query(ge=1, le=200, description="at most so many jobs")]


async def _page(request: Request, response: Response, limit: Limit = 50, after: After = None) -> Page:
    return requested_page(request, response, limit, after)  # shorter than other pages: each job is read for it


@router.get("", summary="Jobs of all kinds, newest first", responses={**problems(422, *OWNER), **NEXT})
def list_jobs(
    context: Shared, page: Annotated[Page, Depends(_page)], state: States = None, kind: Kinds = None
) -> JobListing:
    """What waits, runs and has ended, in short, page by page; `platform.queued` has the order of those that wait.

    `GET` of a job's own path has its request and result.
    """
    kinds = [feature_of(name).kind.name for name in kind] if kind else [each.kind.name for each in job_features()]
    found = list(islice(_newest_first(context, kinds, page.after, state), page.limit + 1))
    items = tuple(found[: page.limit])
    if len(found) > page.limit:
        page.goes_on_after(items[-1].id)
    return JobListing(items=items, next=page.next)


def _newest_first(
    context: Context, kinds: Sequence[str], after: str | None, states: Collection[JobState] | None
) -> Iterator[JobSummary]:
    """Jobs that are older than `after`; None: all.  Raises InputError for an `after` that is no job."""
    ids = {identifier: name for name in kinds for identifier in context.jobs_of(name).job_ids(name)}
    ordered = sorted(ids, key=_created, reverse=True)
    if after is not None:
        if after not in ids:
            remedy = "leave it out, to begin with the newest job"
            raise InputError(f"no job of these kinds is called {after!r}", where="after", remedy=remedy)
        ordered = ordered[ordered.index(after) + 1 :]
    if states is not None:  # else every job that has ended would be read for the few that wait
        chosen = {each for name in kinds for each in context.jobs_of(name).job_ids_in(name, tuple(states))}
        ordered = [identifier for identifier in ordered if identifier in chosen]
    for first in range(0, len(ordered), _AT_ONCE):
        page = ordered[first : first + _AT_ONCE]
        read: dict[str, JobView] = {}
        for name in kinds:
            here = tuple(identifier for identifier in page if ids[identifier] == name)
            read |= {job.identifier: job for job in (context.jobs_of(name).jobs(name, here) if here else ())}
        jobs = [read[identifier] for identifier in page]
        yield from (_summary(job) for job in jobs if states is None or job.state in states)


def _created(identifier: str) -> tuple[str, str]:
    found = _CREATED.search(identifier)
    return ("" if found is None else found[0], identifier)


def _summary(job: JobView) -> JobSummary:
    within = getattr(job.record, "within", None)
    kind = feature_of(job.kind).kind
    return JobSummary(
        id=job.identifier,
        kind=job.kind,
        procedure=getattr(job.request, "kind", None) if kind.submits_steps else None,
        resonator=getattr(job.request, "mounted_resonator", None),
        path=f"/{kind.plural}/{job.identifier}",
        state=job.state,
        progress=job.progress,
        created=job.record.times.created,
        finished=job.record.times.finished,
        clock=job.record.clock,
        within=within,
        recording=getattr(job.result, "recording", None),
        priority=getattr(job.request, "priority", 0),
        paused=job.paused,
        question=job.question,
        error=None if job.error is None else str(job.error),
    )
