"""Errors over the socket: the same class on both sides, with what, where, why and remedy."""

from __future__ import annotations

import structlog
from pydantic import ValidationError

from drivers.errors import PlatformError
from drivers.validation import complaints, listed
from platform_daemon.core.registry import load_errors
from platform_daemon.core.schemas.rpc import RpcError

log = structlog.get_logger()


class HardwareAway(PlatformError):
    """The process that owns the hardware does not answer: it is being started again, or hangs.

    Outputs are off: its guard has seen to that.  Recordings and results can be read meanwhile.
    """

    title = "Hardware process away"
    http_status = 503


def away(why: str) -> HardwareAway:
    """The hardware process does not answer, or not in time."""
    restarted = "repeat the request in some seconds: the process is being restarted"
    remedy = f"{restarted}; what was requested may have begun, so look at the jobs"
    return HardwareAway("the process that owns the hardware does not answer", why=why, remedy=remedy)


class ProcessesDiffer(PlatformError):
    """Two processes of the daemon do not understand each other: they run different versions of the program."""

    title = "Processes differ"
    http_status = 503


def processes_differ(method: str, error: Exception) -> ProcessesDiffer:
    """What was sent over the socket for that method is not of the types of its contract."""
    why = listed(complaints(error.errors())) if isinstance(error, ValidationError) else repr(error)
    return ProcessesDiffer(
        "a process of the daemon does not understand what another one has sent",
        where=f"hardware.sock: {method}",
        why=why,
        remedy="stop the daemon and start it again, so that all its processes are of one version; "
        "what was requested may have begun, so look at the jobs",
    )


def foreseen(error: Exception) -> PlatformError:
    """The error as a message; an unexpected one is named, and the log of this process has its traceback."""
    if isinstance(error, PlatformError):
        return error
    log.error("unexpected_error", exc_info=error)
    remedy = "report it; the log of the daemon has it"
    return PlatformError(f"unexpected {type(error).__name__}", why=str(error), remedy=remedy)


def error_on_wire(error: Exception) -> RpcError:
    """An error as it goes over the socket."""
    error = foreseen(error)
    return RpcError(
        kinds=tuple(each.__name__ for each in type(error).__mro__ if issubclass(each, PlatformError)),
        title=error.title,
        what=error.what,
        where=error.where,
        why=error.why,
        remedy=error.remedy,
    )


def error_from_wire(received: RpcError) -> PlatformError:
    """The error again, of the class it had; of the nearest that this process knows, with its title."""
    known = _kinds()
    if received.kinds and received.kinds[0] not in known:  # of a feature that has done nothing in this process yet
        load_errors()
        known = _kinds()
    kind = next((known[name] for name in received.kinds if name in known), PlatformError)
    error = kind.__new__(kind)
    PlatformError.__init__(error, received.what, where=received.where, why=received.why, remedy=received.remedy)
    error.title = received.title
    return error


def _kinds() -> dict[str, type[PlatformError]]:
    found: dict[str, type[PlatformError]] = {}
    todo: list[type[PlatformError]] = [PlatformError]
    while todo:
        kind = todo.pop()
        found[kind.__name__] = kind
        todo.extend(kind.__subclasses__())
    return found
