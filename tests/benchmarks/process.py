"""How long a fresh process waits for its first fit, how much memory a fit takes, how its time grows."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
import tracemalloc
from dataclasses import replace
from typing import Any

from platform_daemon.estimation.compilation import synthetic_record, warm_up
from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.model import estimate_noise
from tests.benchmarks.fits import DATASETS, Dataset, make_record, milliseconds

_LENGTHS = (1, 2, 4)
_FIRST_FIT = f"""
import json, time
from {fit_ring_down.__module__} import {fit_ring_down.__name__} as fit
from {synthetic_record.__module__} import {synthetic_record.__name__} as made_up
record, noise = made_up()
verdict = fit(record, "thread", noise=noise).verdict
print(json.dumps({{"verdict": verdict, "processor_s": time.process_time()}}))
"""


def run_processes(dataset: Dataset = DATASETS[-1], repeats: int = 10) -> dict[str, Any]:
    """The figures of this file.

    Returns:
        {"first_fit": ..., "memory": ..., "linearity": ...} of `first_fits`, `peak_memory` and `linearity`.
    """
    warm_up()
    return {
        "first_fit": first_fits(),
        "memory": peak_memory(dataset),
        "linearity": linearity(dataset, repeats),
    }


def first_fits() -> dict[str, Any]:
    """Start a process, import, fit once, end: without kernels compiled before, and once more with them.

    Returns:
        {"cold", "warm": {"verdict", "wall_s", "processor_s"}, "must_cold_s", "must_warm_s": of the wall clock}
    """
    with tempfile.TemporaryDirectory() as kernels:
        cold, warm = _first_fit(kernels), _first_fit(kernels)
    return {"cold": cold, "warm": warm, "must_cold_s": 20.0, "must_warm_s": 2.0}


def _first_fit(kernels: str) -> dict[str, Any]:
    """One process that keeps its compiled kernels in this folder."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": kernels, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    began = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", _FIRST_FIT], env=environment, capture_output=True, text=True, check=True
    )
    return {"wall_s": time.perf_counter() - began, **json.loads(done.stdout)}


def peak_memory(dataset: Dataset) -> dict[str, Any]:
    """Largest size of all arrays that a fit, its noise estimate included, holds beside the record.

    Returns:
        {"record_bytes", "peak_bytes", "peak_over_record", "must"}
    """
    record = make_record(dataset)
    tracemalloc.start()
    fit_ring_down(record, dataset.variant, dataset.seconds)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    size = record.samples.nbytes
    return {"record_bytes": size, "peak_bytes": peak, "peak_over_record": peak / size, "must": 3.0}


def linearity(dataset: Dataset, repeats: int) -> dict[str, Any]:
    """Times of fits of the dataset's length and its multiples.

    Returns:
        {"samples", "fit_ms", "relative": time per sample over that at the dataset's own length}, lists.
    """
    samples, times = [], []
    for length in _LENGTHS:
        seconds = length * dataset.seconds
        record = make_record(replace(dataset, seconds=seconds))
        noise = estimate_noise(record)
        samples.append(record.samples.shape[1])
        times.append(milliseconds(lambda: fit_ring_down(record, dataset.variant, seconds, noise=noise), repeats))  # noqa: B023
    relative = [t / n * samples[0] / times[0] for t, n in zip(times, samples, strict=True)]
    return {"samples": samples, "fit_ms": times, "relative": relative}


def processes_text(report: dict[str, Any]) -> str:
    """The report in four lines."""
    first, memory, growth = report["first_fit"], report["memory"], report["linearity"]
    lines = [
        f"first fit of a process, kernels {state}: {first[key]['wall_s']:.1f} s "
        f"(must {first[f'must_{key}_s']:g} s; processor time {first[key]['processor_s']:.1f} s)"
        for key, state in (("cold", "to be compiled"), ("warm", "in the cache"))
    ]
    lines.append(
        f"memory of a fit with its noise estimate: {memory['peak_over_record']:.2f} of the record's "
        f"{memory['record_bytes'] / 1e6:.1f} MB (must {memory['must']:g})"
    )
    steps = ", ".join(f"{t:.1f} ms ({r:.2f})" for t, r in zip(growth["fit_ms"], growth["relative"], strict=True))
    lines.append(f"1, 2, 4 times as many samples: {steps}; in brackets per sample, over the first")
    return "\n".join(lines)
