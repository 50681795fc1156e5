"""Self-tests as jobs: ask (202), watch, cancel."""

from __future__ import annotations

from fastapi import APIRouter, Response

from platform_daemon.schemas import SelfTestJob, SelfTestJobs, SelfTestRequest

from ..context import JobId, Shared
from ..job_routes import JobKind
from ..network.routes import GuardedRoute
from ..problems import OWNER, problems

router = APIRouter(prefix="/self-tests", tags=["self-tests"], route_class=GuardedRoute, responses=problems(*OWNER))
SELF_TESTS = JobKind(
    "self_test",
    "self-tests",
    SelfTestJob,
    SelfTestJobs,
    lambda job: {},
    got="State and progress, and gain and isolation by coil once it has passed.",
    cancelled="Cancel.  It ends within 0.1 s with outputs off.",
)


@router.post("", summary="Is the chain as it should be?", status_code=202, responses=problems(409, 415, 422, 507))
def start_self_test(body: SelfTestRequest, response: Response, context: Shared) -> SelfTestJob:
    """Queue a self-test: a low tone on each coil, heard through the open receive contacts.

    It waits its turn, and is made even where the platform file switches it off before series.  A chain that is not as
    the platform file says is a job that has failed with `self-test-failed`, which names what is wrong.
    """
    return SELF_TESTS.accepted(context.hardware.self_test(body), response)


@router.put("/{identifier}", summary="Change what has not begun", responses=problems(404, 409, 415, 422, 507))
def edit_self_test(identifier: JobId, body: SelfTestRequest, context: Shared) -> SelfTestJob:
    """Another request in the place of that of a self-test that waits; 409 once it has begun."""
    return SELF_TESTS.shown(context.hardware.edit("self_test", identifier, body))


SELF_TESTS.add_routes(router)
