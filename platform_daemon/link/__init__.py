"""Between the process that owns the hardware and all others: one contract, kept over a local socket.

Hardware: What others may ask of the owner of the hardware.
JobHolder: Who holds jobs.
ShownJob: A job as it is at one moment.
Folders: Where the owner of the hardware writes.
OwnedHardware: The contract on an engine in this process.
LinkServer: Answers others on a local socket.
RemoteHardware: The contract over the socket.
HardwareAway: The process that owns the hardware does not answer.
take_up_queue: Queue again what an earlier run has left.
LocalJobs: The jobs of this process, as shown to others.
"""

from .client import RemoteHardware
from .errors import HardwareAway
from .hardware import Hardware, JobHolder
from .jobs import LocalJobs, ShownJob
from .owner import Folders, OwnedHardware
from .queue import take_up_queue
from .server import LinkServer

__all__ = [
    "Folders",
    "Hardware",
    "HardwareAway",
    "JobHolder",
    "LinkServer",
    "LocalJobs",
    "OwnedHardware",
    "RemoteHardware",
    "ShownJob",
    "take_up_queue",
]
