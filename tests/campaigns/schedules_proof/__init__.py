"""Ten simulated years of schedules against an oracle that shares no code with them, and a thousand deaths.

oracle.py    when a trigger is due, minute by minute
years.py     years with daylight saving, clocks that leap, sleeps and restarts
kills.py     SIGKILL at random points: of the scheduler alone, and of the process that owns the hardware
__main__.py  docs/evidence/schedules-proof.md
"""
