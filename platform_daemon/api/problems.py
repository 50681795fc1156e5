"""Every error becomes RFC 9457 problem details: what, where, why, remedy; `type` is a page of this daemon."""

from __future__ import annotations

import re
import secrets
from typing import Any

import structlog
from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from starlette.exceptions import HTTPException

from drivers import errors
from platform_daemon.analysis import UnknownModel
from platform_daemon.engine import UnknownId
from platform_daemon.store import StorageError, UnknownRecording

log = structlog.get_logger()
MEDIA_TYPE = "application/problem+json"

STATUS: dict[type[errors.PlatformError], int] = {
    UnknownId: 404,
    UnknownModel: 404,
    UnknownRecording: 404,
    StorageError: 507,
    errors.InputError: 422,
    errors.DeviceTimeout: 504,
    errors.DeviceStateError: 409,
    errors.DeviceError: 502,
    errors.InterlockError: 409,
    errors.PlatformError: 500,
}


def slug(kind: type[errors.PlatformError]) -> str:
    """`SequenceRejected` -> `sequence-rejected`."""
    return re.sub(r"(?<!^)(?=[A-Z])", "-", kind.__name__).lower()


def problem_kinds() -> dict[str, type[errors.PlatformError]]:
    """Every kind of problem by its slug."""
    found: dict[str, type[errors.PlatformError]] = {}
    todo: list[type[errors.PlatformError]] = [errors.PlatformError]
    while todo:
        kind = todo.pop()
        found[slug(kind)] = kind
        todo.extend(kind.__subclasses__())
    return found


def problem(error: Exception, instance: str | None = None) -> dict[str, Any]:
    """Problem details of any error; an unexpected one gets an id that is also in the log, not its traceback."""
    if not isinstance(error, errors.PlatformError):
        reference = secrets.token_hex(4)
        log.error("unexpected_error", reference=reference, exc_info=error)
        error = errors.PlatformError(
            f"unexpected {type(error).__name__}",
            why=str(error),
            remedy=f"report it; the log has it under {reference}",
        )
    body = {
        "type": f"/problems/{slug(type(error))}",
        "title": error.title,
        "status": status_of(error),
        "detail": str(error),
        "instance": instance,
        "where": error.where or None,
        "remedy": error.remedy or None,
    }
    return {k: v for k, v in body.items() if v is not None}


def status_of(error: errors.PlatformError) -> int:
    """HTTP status of an error: that of the nearest class in its ancestry."""
    return next(STATUS[kind] for kind in type(error).__mro__ if kind in STATUS)


def install(app: FastAPI) -> None:
    """Make the application answer every error in this form."""

    async def ours(request: Request, error: Exception) -> JSONResponse:
        return _respond(problem(error, request.url.path))

    async def validation(request: Request, error: Exception) -> JSONResponse:
        assert isinstance(error, RequestValidationError)
        (place, message), *others = [(".".join(str(p) for p in e["loc"]), e["msg"]) for e in error.errors()]
        text = "; ".join([message, *(f"{p}: {m}" for p, m in others)])
        found = errors.InputError(text, where=place, remedy="correct the request; /docs shows every field")
        return _respond(problem(found, request.url.path))

    async def http(request: Request, error: Exception) -> JSONResponse:
        assert isinstance(error, HTTPException)
        body = {"type": "about:blank", "title": str(error.detail), "status": error.status_code}
        body |= {"instance": request.url.path, "remedy": "GET / lists what there is"}
        return JSONResponse(body, error.status_code, headers=error.headers, media_type=MEDIA_TYPE)

    app.add_exception_handler(RequestValidationError, validation)
    app.add_exception_handler(HTTPException, http)
    app.add_exception_handler(Exception, ours)
    app.add_exception_handler(errors.PlatformError, ours)


def _respond(body: dict[str, Any]) -> JSONResponse:
    return JSONResponse(body, body["status"], media_type=MEDIA_TYPE)
