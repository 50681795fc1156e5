"""The kinds of problems that are answered before a route is reached."""

from __future__ import annotations

from drivers.errors import InputError, PlatformError


class Unauthenticated(InputError):
    """There is no token, or one that is not valid: unknown, revoked, expired."""

    title = "A token is needed"
    http_status = 401
    headers = {"WWW-Authenticate": 'Bearer realm="platform-daemon"'}  # noqa: RUF012 never changed


class RoleTooLow(InputError):
    """The token is valid, but its role may not do that."""

    title = "Another role is needed"
    http_status = 403


class ForeignHost(InputError):
    """The request names a host that is not a name of this server, as after DNS rebinding by a foreign page."""

    title = "Unknown host"
    http_status = 421


class ForeignOrigin(InputError):
    """A page that does not come from this server wants to change something here."""

    title = "Foreign origin"
    http_status = 403


class UnsupportedMediaType(InputError):
    """The content type of a request is not JSON."""

    title = "Unsupported media type"
    http_status = 415


class AmbiguousLength(InputError):
    """The headers of a request say in two ways how long its body is."""

    title = "Two lengths"
    http_status = 400
    headers = {"Connection": "close"}  # noqa: RUF012 never changed; what follows on the connection cannot be trusted


class BodyTooLarge(InputError):
    """The body of the request is longer than any that makes sense."""

    title = "Body too large"
    http_status = 413


class BodyTooSlow(InputError):
    """The body of the request did not come in time."""

    title = "Body too slow"
    http_status = 408


class TooManyRequests(InputError):
    """This client sends more requests than it may."""

    title = "Too many requests"
    http_status = 429

    def __init__(self, what: str, *, wait_s: int, remedy: str) -> None:
        super().__init__(what, remedy=remedy)
        self.headers = {"Retry-After": str(wait_s)}


class Busy(PlatformError):
    """As many requests as may be are running and waiting."""

    title = "Busy"
    http_status = 503
    headers = {"Retry-After": "5"}  # noqa: RUF012 never changed
