"""Errors over the socket: the same class on both sides, with what, where, why and remedy."""

from __future__ import annotations

import structlog

from drivers.errors import PlatformError
from platform_daemon.schemas import LinkError

log = structlog.get_logger()


class HardwareAway(PlatformError):
    """The process that owns the hardware does not answer: it is being started again, or hangs.

    Outputs are off: its guard has seen to that.  Recordings and results can be read meanwhile.
    """

    title = "Hardware process away"


def away(why: str) -> HardwareAway:
    """Nobody answers, or not in time."""
    remedy = "ask again in some seconds: it is started anew; what was asked for may have begun, so look at the jobs"
    return HardwareAway("the process that owns the hardware does not answer", why=why, remedy=remedy)


def foreseen(error: Exception) -> PlatformError:
    """One that nobody foresaw is named, and the log here has its traceback."""
    if isinstance(error, PlatformError):
        return error
    log.error("unexpected_error", exc_info=error)
    remedy = "report it; the log of the daemon has it"
    return PlatformError(f"unexpected {type(error).__name__}", why=str(error), remedy=remedy)


def error_on_wire(error: Exception) -> LinkError:
    """An error as it goes over the socket."""
    error = foreseen(error)
    return LinkError(
        kinds=tuple(each.__name__ for each in type(error).__mro__ if issubclass(each, PlatformError)),
        title=error.title,
        what=error.what,
        where=error.where,
        why=error.why,
        remedy=error.remedy,
    )


def error_from_wire(told: LinkError) -> PlatformError:
    """The error again, of the class it had; of the nearest that this process knows, with its title."""
    known = _kinds()
    kind = next((known[name] for name in told.kinds if name in known), PlatformError)
    error = kind.__new__(kind)
    PlatformError.__init__(error, told.what, where=told.where, why=told.why, remedy=told.remedy)
    error.title = told.title
    return error


def _kinds() -> dict[str, type[PlatformError]]:
    found: dict[str, type[PlatformError]] = {}
    todo: list[type[PlatformError]] = [PlatformError]
    while todo:
        kind = todo.pop()
        found[kind.__name__] = kind
        todo.extend(kind.__subclasses__())
    return found
