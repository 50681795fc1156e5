"""Work by the calendar, and a ledger of what became of each start.

JobOutcome: Where a job that was started is.
Launcher: Who starts works: the owner of the queue.
Schedules: All schedules of a data folder.
UnknownSchedule: No schedule has that id.
"""

from .launcher import JobOutcome, Launcher
from .schedules import Schedules, UnknownSchedule

__all__ = ["JobOutcome", "Launcher", "Schedules", "UnknownSchedule"]
