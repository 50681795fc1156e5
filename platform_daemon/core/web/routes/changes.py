"""Who changed what: the audit log, newest first."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from platform_daemon.core.schemas.access import ChangeListing
from platform_daemon.core.state.errors import StorageError
from platform_daemon.core.web.network.policy import Network
from platform_daemon.core.web.network.routes import GuardedRoute
from platform_daemon.core.web.pages import NEXT, requested_page
from platform_daemon.core.web.problems import problems

router = APIRouter(tags=["platform"], route_class=GuardedRoute)
Limit = Annotated[int, Query(ge=1, le=1000, description="at most so many entries")]
After = Annotated[int | None, Query(ge=0, le=2**53, description="those before this place, as the link says")]


@router.get("/changes", summary="Who changed what, newest first", responses={**NEXT, **problems(422, 507)})
def list_changes(request: Request, response: Response, limit: Limit = 50, after: After = None) -> ChangeListing:
    """What people and programs have changed, started and stopped over REST, as the audit log has it; page by page."""
    network: Network = request.app.state.network
    page = requested_page(request, response, limit, None)
    if network.audit is None:
        return ChangeListing(items=())
    try:
        items, begin = network.audit.newest(limit, after)
    except OSError as error:
        raise StorageError("the audit log cannot be read", where=str(network.audit.path), why=str(error)) from error
    if begin:
        page.goes_on_after(str(begin))
    return ChangeListing(items=items, next=page.next)
