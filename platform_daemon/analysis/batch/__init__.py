"""Fits of many recordings: split into parts, sent to an executor, put together again, kept as they finish.

dask_cluster: An executor on a Dask cluster: archives that outgrow one machine.
executors: Executors on this machine.
ledger: Finished files on disk, one JSON line each: what a crash leaves is whole, and the next run can go on from
    it.
part: What a worker does: open a file, fit some of its frames, say what came out.
run: The loop of a batch: files are cut into parts, sent to the workers, put together, and handed out as they
    finish.
"""
