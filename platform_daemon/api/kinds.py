"""Every kind of problem.  Who looks for them must have loaded the rooms that they come from."""

from __future__ import annotations

from drivers import errors
from platform_daemon.alarms import UnknownAlarm
from platform_daemon.analysis import UnknownModel, UnknownSpecimen
from platform_daemon.engine import ShuttingDown, UnknownId
from platform_daemon.link import HardwareAway
from platform_daemon.schedules import UnknownSchedule
from platform_daemon.store import StorageError, UnknownRecording
from platform_daemon.workers import OverBounds, WorkerLost

from .problems import slug
from .ranged_file import RangeNotSatisfiable

# Errors come over the local socket by the names of their classes, which must be known here to be told apart.
LOADED = (
    *(UnknownAlarm, UnknownModel, UnknownSpecimen, ShuttingDown, UnknownId, HardwareAway, UnknownSchedule),
    *(StorageError, UnknownRecording, OverBounds, WorkerLost, RangeNotSatisfiable),
)


def problem_kinds() -> dict[str, type[errors.PlatformError]]:
    """Every kind of problem by its slug."""
    found: dict[str, type[errors.PlatformError]] = {}
    todo: list[type[errors.PlatformError]] = [errors.PlatformError]
    while todo:
        kind = todo.pop()
        found[slug(kind)] = kind
        todo.extend(kind.__subclasses__())
    return found
