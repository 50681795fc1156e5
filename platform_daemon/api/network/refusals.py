"""The kinds of problems that are answered before a route is reached."""

from __future__ import annotations

from drivers.errors import InputError, PlatformError


class Unauthenticated(InputError):
    """No token, or one that is not valid: never made, revoked, expired."""

    title = "A token is needed"
    headers = {"WWW-Authenticate": 'Bearer realm="platform-daemon"'}  # noqa: RUF012 never changed


class RoleTooLow(InputError):
    """The token is valid, but its role may not do that."""

    title = "Another role is needed"


class ForeignHost(InputError):
    """The request names a host that this server is not called by: a page elsewhere may have had its name lead here."""

    title = "Unknown host"


class ForeignOrigin(InputError):
    """A page that does not come from this server wants to change something here."""

    title = "Foreign origin"


class UnsupportedMediaType(InputError):
    """The body of a request is not said to be JSON."""

    title = "Unsupported media type"


class BodyTooLarge(InputError):
    """The body of the request is longer than any that makes sense."""

    title = "Body too large"


class BodyTooSlow(InputError):
    """The body of the request did not come in time."""

    title = "Body too slow"


class TooManyRequests(InputError):
    """This client asks more often than is allowed."""

    title = "Too many requests"

    def __init__(self, what: str, *, wait_s: int, remedy: str) -> None:
        super().__init__(what, remedy=remedy)
        self.headers = {"Retry-After": str(wait_s)}


class Busy(PlatformError):
    """So many requests compute or wait that this one was not begun."""

    title = "Busy"
    headers = {"Retry-After": "5"}  # noqa: RUF012 never changed
