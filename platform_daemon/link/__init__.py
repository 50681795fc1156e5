"""Between the process that owns the hardware and all others: one contract, kept over a local socket.

Hardware: What others may ask of the owner of the hardware.
JobHolder: Who holds jobs.
ShownJob: A job as it is at one moment.
Folders: Where the owner of the hardware writes.
OwnedHardware: The contract on an engine in this process.
LinkServer: Answers others on a local socket.
RemoteHardware: The contract over the socket.
Stopper: Everything off, whoever answers on the socket.
STOPPED: Why schedules are paused by it.
StoppedMeanwhile: What was asked for before a stop is not done after it.
stop_mark: That somebody asked to stop while nobody owned the hardware.
HardwareAway: The process that owns the hardware does not answer.
HardwareLauncher: Starts scheduled works on the owner of the hardware.
LocalJobs: The jobs of this process, as shown to others.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
