"""From a request in physical units to the sample-exact timeline, inside the safety envelope; pure functions only.

Read in this order: `request.py` (what is asked), `windows.py` (samples), `drive.py` (field to volts), `limits.py`
(the envelope), `compiler.py` (all of it together), `settle.py` (does the resonator come to rest in between?).
"""
