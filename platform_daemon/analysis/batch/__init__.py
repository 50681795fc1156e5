"""Fits of many recordings: split into parts, sent to an executor, put together again, kept as they finish.

run        the loop: files -> parts -> executor -> finished files, one after the other
part       what a worker does: open, fit its frames
pool       executors on this machine: a process per core, or none
cluster    an executor on a Dask cluster (optional extra)
ledger     finished files on disk, one line each, so that an interrupted batch can go on
"""
