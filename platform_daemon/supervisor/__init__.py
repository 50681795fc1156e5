"""Outside the process that owns the devices: what switches them off when that process dies or hangs.

guard_for: A guard for a platform, unless all of its devices die with the process.
needs_guard: Does some output of it outlive its owner?
outputs_off: Switch all outputs off while no owner lives.
reset_fault: The same, then clear the fault that stands in the way of power.
owner_of: Who owns the devices of a place now.
place_of: Where the state of a platform's outputs is kept.
Heartbeat: Lives as long as it is called often enough.
service_manager: Tells systemd that the daemon is ready, lives, and ends.
examine: Would this computer run unattended?

owner.py     the owner's end: starting the guard, signs of life, and what happens if the guard itself is gone
watch.py     what the guard does, in a process of its own
rescue.py    outputs off by other hands than their owner's, proved, and written down
lock_file.py what stands in the way of power until a named person has reset it
ownership.py one process at a time owns the devices
places.py    where that is kept
notify.py    what systemd is told
checkup.py   what would keep a computer from running unattended; machine.py: the computer's part of it
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
