"""Every kind of problem.  Who looks for them must have loaded the rooms that they come from."""

from __future__ import annotations

from drivers import errors
from platform_daemon.core.jobs.job_registry import UnknownId
from platform_daemon.core.jobs.submit_options import ShuttingDown
from platform_daemon.core.jobs.workers.bounds import OverBounds, WorkerLost
from platform_daemon.core.registry import load_errors
from platform_daemon.core.service.errors import HardwareAway
from platform_daemon.core.state.errors import StorageError, UnknownRecording

from .problems import slug
from .ranged_file import RangeNotSatisfiable

# Errors come over the local socket by the names of their classes, which must be known here to be told apart.
LOADED = (
    *(ShuttingDown, UnknownId, HardwareAway),
    *(StorageError, UnknownRecording, OverBounds, WorkerLost, RangeNotSatisfiable),
)


def problem_kinds() -> dict[str, type[errors.PlatformError]]:
    """Every kind of problem by its slug."""
    load_errors()
    found: dict[str, type[errors.PlatformError]] = {}
    todo: list[type[errors.PlatformError]] = [errors.PlatformError]
    while todo:
        kind = todo.pop()
        found[slug(kind)] = kind
        todo.extend(kind.__subclasses__())
    return found
