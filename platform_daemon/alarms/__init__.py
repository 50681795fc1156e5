"""What somebody should know: rules over events and over the computer, and a board of what stands.

AlarmBoard: The alarms there are, kept on disk.
Caller: Runs a command or calls a URL for each alarm.
UnknownAlarm: No alarm has that name.
Watch: Follows the events and looks at the computer.
Watched: What is looked at, and from which value on somebody should know.
"""

from .board import AlarmBoard, UnknownAlarm
from .caller import Caller
from .watch import Watch, Watched

__all__ = ["AlarmBoard", "Caller", "UnknownAlarm", "Watch", "Watched"]
