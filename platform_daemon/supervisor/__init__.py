"""Outside the process that owns the devices: what switches them off when that process dies or hangs.

guard_for: A guard for a platform, unless all of its devices die with the process.
needs_guard: Does some output of it outlive its owner?
outputs_off: Switch all outputs off while no owner lives.
reset_fault: The same, then clear the fault that stands in the way of power.
owner_of: Who owns the devices of a place now.
place_of: Where the state of a platform's outputs is kept.
standing: The fault that nobody has reset.
Fault: What happened when an owner died or hung.

owner.py     the owner's end: starting the guard, signs of life, and what happens if the guard itself is gone
watch.py     what the guard does, in a process of its own
rescue.py    outputs off by other hands than their owner's, proved, and written down
lock_file.py what stands in the way of power until a named person has reset it
ownership.py one process at a time owns the devices
places.py    where that is kept
"""

from .lock_file import Fault, standing
from .owner import guard_for, needs_guard
from .ownership import owner_of
from .places import place_of
from .rescue import outputs_off, reset_fault

__all__ = ["Fault", "guard_for", "needs_guard", "outputs_off", "owner_of", "place_of", "reset_fault", "standing"]
