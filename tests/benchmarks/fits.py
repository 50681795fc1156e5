"""A repeatable benchmark: the paper's four datasets, own time per fit, beside a floor and beside the paper's method.

    python -m tests.benchmarks.fits

Times are processor times of one thread, medians of several warm fits, from raw dm/dt samples with automatic start
values; the noise is estimated once per series and timed apart. All runs of one call share the machine's mood: compare
ratios, not milliseconds.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from typing import Any

import numpy as np

from platform_daemon.estimation.compilation import warm_up
from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.numerics.arrays import Array, ComplexArray
from platform_daemon.estimation.physics.models import model_named
from platform_daemon.estimation.physics.rotation import rotation_from_rodrigues
from platform_daemon.estimation.physics.trajectory.basis_functions import DIPOLE
from platform_daemon.estimation.physics.trajectory.direct import MotionParameters, Trajectory
from platform_daemon.estimation.record import RingDownRecord
from tests.benchmarks.paper import PaperFit, paper_method

RATE_HZ = 125e6 / 2048
NOISE_SD = np.array([0.014, 0.021, 0.055])  # A m^2/s per sample, fig. 6 of the paper
_HARMONICS = 5
_BLOCK = 256
_RODRIGUES = np.array([0.0625, -0.0156, -1.53])


@dataclass(frozen=True)
class Dataset:
    """One of the paper's datasets: the first `seconds` of a ring-down with typical parameters."""

    name: str
    variant: str
    seconds: float
    m_r_am2: float
    dynamics: MotionParameters
    must_ms: float
    aim_ms: float


_JEWEL = MotionParameters(w=2.0 * math.pi * 213.25, theta=2.3, amplitude=0.93, values=(0.2465, 1190.0))
_THREAD = MotionParameters(w=2.0 * math.pi * 215.5, theta=2.3, amplitude=0.39, values=(0.2465,))
DATASETS = (
    Dataset("JN50", "jewel", 0.24, 0.01226, _JEWEL, 3.0, 0.8),
    Dataset("JD30", "jewel", 1.28, 0.01226, _JEWEL, 10.0, 2.5),
    Dataset("TN50", "thread", 0.24, 0.01165, _THREAD, 3.0, 0.7),
    Dataset("TD30", "thread", 4.90, 0.01165, _THREAD, 20.0, 5.0),
)


def make_record(dataset: Dataset, seed: int = 0) -> RingDownRecord:
    """A noisy record of the dataset, dm/dt."""
    d, n = dataset.dynamics, round(dataset.seconds * RATE_HZ)
    basis = Trajectory(model_named(dataset.variant), d, dataset.seconds).basis(0, n, 1.0 / RATE_HZ, DIPOLE)
    gains = d.w * dataset.m_r_am2 * rotation_from_rodrigues(_RODRIGUES)[:, [1, 0]]
    noise = np.random.default_rng(seed).standard_normal((3, n)) * NOISE_SD[:, None]
    return RingDownRecord(gains @ basis[:2] + noise, RATE_HZ, "dmdt")


def demodulate(samples: Array, frequency_hz: float) -> ComplexArray:
    """Complex amplitudes of five harmonics, (5, channels), over all whole blocks: the least that any method must do."""
    blocks = samples.shape[1] // _BLOCK
    harmonics = np.arange(1, _HARMONICS + 1)
    turn = -2j * np.pi * frequency_hz / RATE_HZ
    wave = np.exp(turn * np.outer(np.arange(_BLOCK), harmonics))
    inside = samples[:, : blocks * _BLOCK].reshape(-1, blocks, _BLOCK) @ np.hstack([wave.real, wave.imag])
    amplitudes = inside[..., :_HARMONICS] + 1j * inside[..., _HARMONICS:]
    phases = np.exp(turn * _BLOCK * np.outer(np.arange(blocks), harmonics))
    return np.asarray(np.einsum("cbk,bk->kc", amplitudes, phases)) * (2.0 / (blocks * _BLOCK))


def milliseconds(work: Callable[[], Any], repeats: int) -> float:
    """Median processor time of this thread."""
    times = []
    for _ in range(repeats):
        began = time.thread_time()
        work()
        times.append(time.thread_time() - began)
    return 1e3 * median(times)


def run_bench(
    *, repeats: int = 25, paper_seconds: float = 20.0, datasets: tuple[Dataset, ...] = DATASETS
) -> dict[str, Any]:
    """Time the datasets.

    Args:
        repeats: fits per dataset.
        paper_seconds: time box for the paper's method per dataset; 0: leave it out.
        datasets: which.

    Returns:
        {"warm_up_s", "datasets": {name: {"samples", "fit_ms", "noise_ms", "demodulation_ms", "fit_over_demodulation",
        "iterations", "verdict", "must_ms", "aim_ms", "paper_s", "paper_finished", "paper_over_fit"}}}; the paper's
        entries are None where it was left out, and lower bounds where it did not finish.
    """
    warm_s = warm_up()
    return {"warm_up_s": warm_s, "datasets": {d.name: _one(d, repeats, paper_seconds) for d in datasets}}


def _one(dataset: Dataset, repeats: int, paper_seconds: float) -> dict[str, Any]:
    """Times of one dataset."""
    record = make_record(dataset)
    noise = estimate_noise(record)
    result = fit_ring_down(record, dataset.variant, dataset.seconds, noise=noise)
    fit_ms = milliseconds(lambda: fit_ring_down(record, dataset.variant, dataset.seconds, noise=noise), repeats)
    floor_ms = milliseconds(lambda: demodulate(record.samples, dataset.dynamics.w / (2.0 * math.pi)), repeats)
    paper: PaperFit | None = None
    if paper_seconds > 0.0:
        paper = paper_method(record.samples, RATE_HZ, dataset.dynamics, dataset.m_r_am2, _RODRIGUES, paper_seconds)
    return {
        "samples": record.samples.shape[1],
        "fit_ms": fit_ms,
        "noise_ms": milliseconds(lambda: estimate_noise(record), 3),
        "demodulation_ms": floor_ms,
        "fit_over_demodulation": fit_ms / floor_ms,
        "iterations": result.iterations,
        "verdict": result.verdict,
        "must_ms": dataset.must_ms,
        "aim_ms": dataset.aim_ms,
        "paper_s": None if paper is None else paper.seconds,
        "paper_finished": None if paper is None else paper.finished,
        "paper_over_fit": None if paper is None else 1e3 * paper.seconds / fit_ms,
    }


def table(report: dict[str, Any]) -> str:
    """The report as text."""
    lines = [f"{'':6}{'fit':>9}{'must':>7}{'aim':>7}{'noise':>9}{'demod.':>9}{'ratio':>8}{'paper':>13}{'ratio':>11}"]
    for name, row in report["datasets"].items():
        paper = ratio = "-"
        if row["paper_s"] is not None:
            more = "" if row["paper_finished"] else "> "
            paper, ratio = f"{more}{row['paper_s']:.1f} s", f"{more}{row['paper_over_fit']:.0f}"
        lines.append(
            f"{name:6}{row['fit_ms']:6.2f} ms{row['must_ms']:7g}{row['aim_ms']:7g}{row['noise_ms']:6.1f} ms"
            f"{row['demodulation_ms']:6.2f} ms{row['fit_over_demodulation']:8.1f}{paper:>13}{ratio:>11}"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    print(table(run_bench()))
