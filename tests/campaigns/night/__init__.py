"""A night of scheduled series over the emulated wires with random faults that nobody looks after.

blows: What is done to lab and daemon.
night: The night: schedules, blows, and in the morning what everybody tells.
story: Do ledger, jobs, recordings, events, alarms and the world tell the same?
"""
