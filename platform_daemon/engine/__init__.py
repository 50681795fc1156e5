"""Who owns the hardware: one thread, one queue of jobs, one way to make a shot.

`shot.py` makes one shot safely, `acquisition.py` a series of them, `jobs.py` says how far it is, `engine.py` runs all.
"""
