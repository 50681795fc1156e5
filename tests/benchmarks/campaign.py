"""The paper's campaign, timed: 100 shots of each of its four datasets, on all cores.

Every process holds its share of the shots in memory and has its kernels loaded before the clock starts; that start-up
is stated apart, and so is the noise, which is estimated once per series.
"""

from __future__ import annotations

import multiprocessing
import time
from multiprocessing.connection import Connection
from typing import Any

from platform_daemon.estimation.compilation import warm_up
from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.model import estimate_noise
from tests.benchmarks.fits import DATASETS, make_record


def run_campaign(shots: int = 100, processes: int = 2) -> dict[str, Any]:
    """Fit `shots` shots of each dataset.

    Returns:
        {"fits", "processes", "good", "wall_s", "processor_s": summed over processes, "start_s": processes, kernels and
        records, "must_s": for 400 fits}
    """
    began = time.perf_counter()
    context = multiprocessing.get_context("spawn")
    pipes = [context.Pipe() for _ in range(processes)]
    workers = [
        context.Process(target=_work, args=(theirs, range(k, shots, processes)), daemon=True)
        for k, (_, theirs) in enumerate(pipes)
    ]
    for worker, (_, theirs) in zip(workers, pipes, strict=True):
        worker.start()
        theirs.close()  # so that a worker that dies ends the waiting
    ours = [own for own, _ in pipes]
    for own in ours:
        own.recv()
    ready = time.perf_counter()
    for own in ours:
        own.send("go")
    answers = [own.recv() for own in ours]
    ended = time.perf_counter()
    for worker in workers:
        worker.join()
    return {
        "fits": shots * len(DATASETS),
        "processes": processes,
        "good": sum(good for good, _ in answers),
        "wall_s": ended - ready,
        "processor_s": sum(seconds for _, seconds in answers),
        "start_s": ready - began,
        "must_s": 2.0,
    }


def _work(pipe: Connection, seeds: range) -> None:
    """One process: make its shots, say so, wait, fit them all."""
    warm_up()
    shots = [(d, make_record(d, seed)) for seed in seeds for d in DATASETS]
    noise = {d.name: estimate_noise(make_record(d)) for d in DATASETS}
    pipe.send("ready")
    pipe.recv()
    began = time.thread_time()
    fits = [fit_ring_down(record, d.variant, d.seconds, noise=noise[d.name]) for d, record in shots]
    pipe.send((sum(fit.verdict == "good" for fit in fits), time.thread_time() - began))


def campaign_text(report: dict[str, Any]) -> str:
    """The report in two lines."""
    return (
        f"campaign of {report['fits']} fits, {report['processes']} processes: {report['wall_s']:.2f} s "
        f"(must {report['must_s']:g} s for 400; processor time {report['processor_s']:.2f} s in all); "
        f"{report['good']} good\nbefore it: processes, kernels and records ready after {report['start_s']:.1f} s"
    )
