"""What an answer of the daemon means: a value, or one of the exceptions."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from typing import Any, Generic, TypeVar, cast
from urllib.parse import quote

import httpx2
from pydantic import BaseModel, TypeAdapter, ValidationError

from drivers.errors import InputError
from drivers.validation import complaints, listed
from platform_daemon import __version__
from platform_daemon.core.schemas.problems import Problem

from .errors import ConnectionFailed, NotADaemon, Refused, VersionMismatch, refused
from .operations import Operation

T = TypeVar("T")
PATIENCE_S = 30.0
"""How long a request that may be repeated is repeated while the daemon does not answer, or asks to wait, s."""
FIRST_WAIT_S, LONGEST_WAIT_S = 0.1, 2.0
TIMEOUT = httpx2.Timeout(60.0, connect=5.0)
"""Of one request: the longest silence, s.  Long work is a job, so that no request lasts as long as a measurement."""


class Page(BaseModel, Generic[T]):
    """A page of a list; what else stands in it belongs to the list and not to an entry."""

    items: tuple[T, ...]
    next: str | None


def checked_url(url: str) -> httpx2.URL:
    """The address of a daemon.  Raises InputError."""
    try:
        found = httpx2.URL(url)
    except httpx2.InvalidURL as error:
        found, why = None, str(error)
    else:
        why = "it does not begin with http:// or https://"
    if found is None or found.scheme not in ("http", "https") or not found.host:
        remedy = "give the address that `platform-daemon serve` prints, as http://127.0.0.1:8212"
        raise InputError(f"{url!r} is no address of a daemon", where="url", why=why, remedy=remedy)
    return found


def path_of(operation: Operation, values: Mapping[str, Any]) -> str:
    """The path of a request, with its variables filled in."""
    return operation.path.format(**{name: quote(str(value), safe="") for name, value in values.items()})


@cache
def _adapter(model: Any) -> TypeAdapter[Any]:
    return TypeAdapter(model)


def value_of(response: httpx2.Response, model: type[T]) -> T:
    """The value in an answer.  Raises NotADaemon if it is not of that type."""
    return value_from(response.content, model, str(response.request.url))


def value_from(content: bytes | str, model: type[T], where: str) -> T:
    """The value in a JSON text.  Raises NotADaemon if it is not of that type."""
    try:
        value: T = _adapter(cast(Any, model)).validate_json(content)
    except ValidationError as error:
        why = listed(complaints(error.errors()))
        remedy = "check the address; if it is right, install the version of the daemon"
        raise NotADaemon("the answer is not what a platform daemon says", where=where, why=why, remedy=remedy) from None
    return value


def page_of(response: httpx2.Response, model: type[T]) -> Page[T]:
    """The page of a list in an answer.  Raises NotADaemon if it is none."""
    found: Page[T] = value_of(response, cast(Any, Page)[model])
    return found


def check(response: httpx2.Response) -> None:
    """Raises Refused, of the class of the status, or NotADaemon for an error without problem details."""
    if response.is_success:
        return
    where = str(response.request.url)
    try:
        problem = Problem.model_validate_json(response.content)
    except ValidationError:
        why = f"it answers {response.status_code} without problem details"
        remedy = "check the address, and what stands between: a proxy answers so when the daemon is down"
        raise NotADaemon("the answer is not what a platform daemon says", where=where, why=why, remedy=remedy) from None
    raise refused(problem)


def check_version(response: httpx2.Response) -> None:
    """Raises NotADaemon or VersionMismatch by the answer to GET /health."""
    where = str(response.request.url)
    try:
        found = json.loads(response.content)
        version = str(found["version"])
    except (ValueError, TypeError, LookupError):
        why = f"GET /health is answered {response.status_code} with {response.text[:60]!r}"
        remedy = "give the address that `platform-daemon serve` prints"
        raise NotADaemon("this is no platform daemon", where=where, why=why, remedy=remedy) from None
    if version != __version__:
        raise VersionMismatch(
            f"the daemon is version {version}, this client {__version__}",
            where=where,
            why="models of requests and results differ between versions",
            remedy=f"install platform-daemon=={version} here, or update the daemon",
        )


def connection_failed(error: Exception, url: httpx2.URL, operation: Operation, *, key: str | None) -> ConnectionFailed:
    """Nothing answers, or no longer; says whether something may have begun."""
    began = operation.repeatable or isinstance(error, httpx2.ConnectError)
    remedy = "check the address and whether the daemon runs (`platform-daemon serve`)"
    if not began and key is None:
        remedy += "; the request may have been carried out, so look before it is sent again"
    elif not began:
        remedy += f"; the same call with idempotency_key={key!r} starts no second job"
    what = "nothing answers" if isinstance(error, httpx2.ConnectError) else "the answer did not come"
    return ConnectionFailed(what, where=str(url), why=str(error) or type(error).__name__, remedy=remedy)


def will_pass(response: httpx2.Response) -> bool:
    """Whether the same request may be answered otherwise a moment later: the daemon is busy, or starts again."""
    from_proxy = response.status_code in (502, 504) and "problem" not in response.headers.get("Content-Type", "")
    return response.status_code in (429, 503) or from_proxy


def wait_of(response: httpx2.Response, before_s: float) -> float:
    """How long to wait before a request is repeated, s."""
    said = response.headers.get("Retry-After", "")
    return min(float(said) if said.isdecimal() else before_s, LONGEST_WAIT_S)


def not_found(what: str, name: str, known: list[str]) -> Refused:
    """Nothing has that name, of what the daemon knows by its names."""
    detail = f"no {what} is called {name!r}"
    remedy = f"one of: {', '.join(sorted(known)[:20])}" if known else f"add a {what} first"
    return refused(Problem(type="about:blank", title="Not found", status=404, detail=detail, where=name, remedy=remedy))
