"""Outside the process that owns the devices: what switches them off when that process dies or hangs.

guard_for: A guard for a platform, unless all of its devices die with the process.

owner.py     the owner's end: starting the guard, signs of life, and what happens if the guard itself is gone
watch.py     what the guard does, in a process of its own
"""

from .owner import guard_for

__all__ = ["guard_for"]
