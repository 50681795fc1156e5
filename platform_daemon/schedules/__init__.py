"""Work by the calendar, and a ledger of what became of each start.

JobOutcome: Where a job that was started is.
Launcher: Who starts works: the owner of the queue.
ScheduleKeeper: The schedules of a data folder, however its disk was when the daemon began.
Schedules: All schedules of a data folder.
UnknownSchedule: No schedule has that id.
rest_mark: Of a ledger: all of them shall be paused before anything starts.
"""

from .keeper import ScheduleKeeper
from .launcher import JobOutcome, Launcher
from .schedules import Schedules, UnknownSchedule, rest_mark

__all__ = ["JobOutcome", "Launcher", "ScheduleKeeper", "Schedules", "UnknownSchedule", "rest_mark"]
