"""Work by the calendar, and a ledger of what became of each start.

JobOutcome: Where a job that was started is.
Launcher: Who starts works: the owner of the queue.
Schedules: All schedules of a data folder.
"""

from .launcher import JobOutcome, Launcher
from .schedules import Schedules

__all__ = ["JobOutcome", "Launcher", "Schedules"]
