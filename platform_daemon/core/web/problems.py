"""Every error becomes RFC 9457 problem details: what, where, why, remedy; `type` is a page of this daemon."""

from __future__ import annotations

import re
import secrets
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import structlog
from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.routing import compile_path

from drivers import errors
from drivers.validation import complaints, listed
from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.schemas.problems import Problem, UnreadableFile

from .network.refusals import UnsupportedMediaType

if TYPE_CHECKING:
    from platform_daemon.core.recordings.index import Broken

log = structlog.get_logger()
MEDIA_TYPE = "application/problem+json"

WHEN = {
    400: "The headers say in two ways how long the body is",
    401: "No token, or one that is not valid",
    403: "The token has another role, or the request comes from a page of another server",
    404: "There is nothing of that id or name",
    409: "It does not fit the state that the platform is in",
    408: "The body did not come in time",
    413: "The body is too large, or the work takes more than one request may",
    415: "The body is not said to be JSON",
    416: "The file ends before the range of bytes begins",
    421: "The request names a host that this server is not",
    422: "The request is wrong, or cannot be carried out; nothing has moved",
    423: "Another program has the recording open for writing; try again when it has closed it",
    429: "This client asks too often; Retry-After says how long to wait",
    500: "An unexpected error; the log has it",
    502: "A device failed",
    503: "The daemon is shutting down, has too much work, or its hardware process or the index of recordings is away",
    504: "A device did not answer in time",
    507: "The disk refused to write",
}
MOST_EXPLAINED = 200
"""Complaints about one request: a body of 1 MB can cause 100 000, and to write them would delay all other requests."""
OWNER = 502, 503, 504
"""Statuses of requests to the hardware process: it may be down, or its devices may not be open."""


def problems(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """The error answers that a route declares."""
    return {status: {"model": Problem, "description": WHEN[status]} for status in statuses}


def slug(kind: type[errors.PlatformError]) -> str:
    """`SequenceRejected` -> `sequence-rejected`."""
    return re.sub(r"(?<!^)(?=[A-Z])", "-", kind.__name__).lower()


def problem(error: Exception, instance: str | None = None) -> Problem:
    """Problem details of any error; an unexpected one gets an id that is also in the log, not its traceback."""
    if not isinstance(error, errors.PlatformError):
        reference = secrets.token_hex(4)
        log.error("unexpected_error", reference=reference, exc_info=error)
        error = errors.PlatformError(
            f"unexpected {type(error).__name__}",
            why=str(error),
            remedy=f"report it; the log has it under {reference}",
        )
    return Problem(
        type=f"/problems/{slug(type(error))}",
        title=error.title,
        status=error.http_status,
        detail=str(error),
        instance=instance,
        where=error.where or None,
        remedy=error.remedy or None,
    )


def unreadable(broken: Broken) -> UnreadableFile:
    """A line of a list about a file that cannot be used."""
    return UnreadableFile(id=broken.id, path=broken.path.name, error=problem(broken.error))


def install(app: FastAPI) -> None:
    """Make the application answer every error in this form."""

    async def ours(request: Request, error: Exception) -> Response:
        return respond(error, request.url.path)

    async def validation(request: Request, error: Exception) -> Response:
        assert isinstance(error, RequestValidationError)
        return _respond(problem(_explained(request, error), request.url.path))

    async def http(request: Request, error: Exception) -> Response:
        assert isinstance(error, HTTPException)
        if error.status_code == 400:  # how FastAPI takes what Python's reader of JSON gives up on
            what = "the body is not text in UTF-8, is nested too deep, or holds a number that is too long"
            return _respond(problem(_no_json(what), request.url.path))
        headers = dict(error.headers or {})
        remedy = "GET / lists what there is"
        if error.status_code == 405:  # Starlette names the methods of the first route only that has the path
            headers["Allow"] = _allowed(request, headers.get("Allow", ""))
            remedy = f"use {headers['Allow']}"
        body = Problem(
            type="about:blank",
            title=str(error.detail),
            status=error.status_code,
            detail=f"{request.method} {request.url.path}: {error.detail}. Remedy: {remedy}.",
            instance=request.url.path,
            remedy=remedy,
        )
        return _respond(body, headers)

    app.add_exception_handler(RequestValidationError, validation)
    app.add_exception_handler(HTTPException, http)
    app.add_exception_handler(Exception, ours)
    app.add_exception_handler(errors.PlatformError, ours)


def respond(error: Exception, path: str) -> Response:
    """The answer of an error to a request for a path, with the headers that its kind has."""
    return _respond(problem(error, path), getattr(error, "headers", None))


def _allowed(request: Request, by_first: str) -> str:
    """The methods of a path: of its own, else of the longest whose variable parts fit; a greedy one hides none."""
    known: dict[str, set[str]] = request.app.state.methods
    path = request.url.path
    fitting = [path] if path in known else [each for each in known if compile_path(each)[0].match(path)]
    return ", ".join(sorted(known[max(fitting, key=len)])) if fitting else by_first


def _explained(request: Request, error: RequestValidationError) -> errors.InputError:
    """The complaints about a request as one error."""
    entries = error.errors()
    unread, entries = len(entries) - MOST_EXPLAINED, entries[:MOST_EXPLAINED]
    if entries[0]["type"] == "json_invalid":
        return _no_json(f"the body is not JSON: {entries[0]['ctx']['error']} at character {entries[0]['loc'][-1]}")
    if isinstance(error.body, bytes):
        content_type = request.headers.get("content-type")
        return UnsupportedMediaType(
            f"the body is sent as {content_type}" if content_type else "the request does not say what its body is",
            # A browser sends that for any page, which must not be able to move hardware behind its user's back.
            why="only JSON is taken, and only if the request says that it is",
            where="Content-Type",
            remedy="add the header, with curl: -H 'Content-Type: application/json'",
        )
    field = getattr(request.scope.get("route"), "body_field", None)
    body = [{**e, "loc": e["loc"][1:]} for e in entries if e["loc"][0] == "body"]
    others = [{**e, "loc": e["loc"][1:]} for e in entries if e["loc"][0] != "body"]
    first, *rest = [*complaints(others), *complaints(body, None if field is None else field.field_info.annotation)]
    text = listed([first.what, *rest]) + (f"; {unread} other complaints were not looked at" if unread > 0 else "")
    where = first.where or "body"
    return errors.InputError(text, where=where, remedy="correct the request; /docs shows every field with its unit")


def _no_json(what: str) -> errors.InputError:
    return errors.InputError(what, where="body", remedy="send JSON, with double quotes around keys and text")


def _respond(body: Problem, headers: Mapping[str, str] | None = None) -> Response:
    # The text of a client may hold lone surrogates, which can only be sent back escaped.
    return Response(to_json(body), body.status, headers, MEDIA_TYPE)
