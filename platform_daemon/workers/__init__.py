"""Computing in processes of their own, with limits of memory and time; killed to cancel.

It knows nothing of what is computed: a task is anything that can be pickled and called.

Call: A function with its arguments, as a task.
Computer: Who computes.
Task: What is computed.
InThisProcess: No other process.
WorkerProcess: One process, which computes one thing after the other.
Pool: Several of them.
Stopped: Somebody asked it to stop.
OverBounds: It took more than it may.
WorkerLost: The process that computed it died.
WorkerLimits: What each kind of task may take.
in_time: A limit of time for what is computed in this process.
check_time: Raises OverBounds once that is over.
"""

from .bounds import OverBounds, Stopped, WorkerLost
from .computer import Call, Computer, InThisProcess, Task
from .in_time import check_time, in_time
from .limits import WorkerLimits
from .pool import Pool
from .process import WorkerProcess

__all__ = [
    "Call",
    "Computer",
    "InThisProcess",
    "OverBounds",
    "Pool",
    "Stopped",
    "Task",
    "WorkerLimits",
    "WorkerLost",
    "WorkerProcess",
    "check_time",
    "in_time",
]
