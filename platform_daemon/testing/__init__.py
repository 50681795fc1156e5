"""For tests of other people: a plugin of pytest, and a comparison of a fit with the truth.

plugin.py       fixtures: platform_daemon, faulty_platform, recording
processes.py    daemons and emulated labs as processes
assertions.py   assert_within
"""

from .assertions import assert_within

__all__ = ["assert_within"]
