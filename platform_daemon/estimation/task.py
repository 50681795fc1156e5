"""What is to be fitted, whichever model does it: a screened record, its noise, and the samples of a window."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from .least_squares.problem import FitProblem
from .noise.model import NoiseModel, estimate_noise
from .record import RingDownRecord
from .refusal import Refusal, RefusedError
from .screening.periods import FEW_PERIODS, counted_periods
from .screening.screening import FEWEST_PERIODS, refuse_few_periods, refuse_few_swings, screen
from .screening.two_resonators import refuse_two_lines
from .screening.windows import SampleRange, Window, select_window

_SLOWEST_HZ = 20.0  # a fifth of the slowest resonator whose dm/dt can be seen


@dataclass(frozen=True)
class Task:
    """A record ready to be fitted."""

    record: RingDownRecord
    noise: NoiseModel
    noise_sd: np.ndarray
    chosen: SampleRange
    frequency_hz: float
    fixed: Mapping[str, float]
    noise_seconds: float
    doubts: tuple[str, ...] = ()

    @property
    def samples(self) -> int:
        """Samples per channel in the window."""
        return self.chosen.last - self.chosen.first

    @property
    def periods(self) -> float:
        """Periods in the window."""
        return self.samples * self.record.dt_s * self.frequency_hz

    def at_level(self, ratio: float, source: str) -> Task:
        """The task with so many times the noise, but no less than rounding makes."""
        sd = np.maximum(self.noise_sd * ratio, _smallest_sd(self.record))
        return replace(self, noise=self.noise.at_level(ratio, source), noise_sd=sd)

    def with_white_noise(self, sd: float, source: str) -> Task:
        """The task with white noise of this standard deviation in every channel."""
        every = np.full(self.record.channels, sd)
        noise = replace(NoiseModel.white(every, self.record.sampling_rate_hz), source=source)
        return replace(self, noise=noise, noise_sd=np.maximum(every, _smallest_sd(self.record)))

    def degrees(self, problem: FitProblem) -> int:
        """Degrees of freedom of the residual."""
        return self.record.channels * self.samples - int(np.count_nonzero(problem.free))


def task_of(record: RingDownRecord, window: Window, noise: NoiseModel | None, fixed: Mapping[str, float]) -> Task:
    """Screen the record, measure its noise, choose the samples."""
    line = screen(record)
    began = time.perf_counter()
    noise = estimate_noise(record) if noise is None else noise
    noise_seconds = time.perf_counter() - began
    sd = _usable_sd(noise, record)
    if record.quantity == "angle":
        refuse_few_swings(record, line.frequency_hz)
    chosen = select_window(record, window, line.frequency_hz, sd)
    if chosen.last <= chosen.first:
        raise RefusedError(Refusal.TOO_SHORT, "the window ends before the valid samples begin")
    task = Task(record, noise, sd, chosen, line.frequency_hz, fixed, noise_seconds)
    if task.periods < FEW_PERIODS and record.quantity != "angle":
        seen = record.samples[:, chosen.first : chosen.last]
        counted = counted_periods(seen, record.dt_s, line.frequency_hz)
        task = replace(task, frequency_hz=counted / (task.samples * record.dt_s))
    try:
        _refuse_slow_change(task, window)
        refuse_few_periods(task.samples * record.dt_s, task.frequency_hz)
    except RefusedError:
        # A beat can be why so few periods came before the decay to 30 %.
        if window == "d30" and record.quantity != "angle" and line.frequency_hz > _SLOWEST_HZ:
            refuse_two_lines(record, line.frequency_hz, sd)
        raise
    return task


def _refuse_slow_change(task: Task, window: Window) -> None:
    """Refuse what is no oscillation of a resonator: it lasts for less than a period, or for a few far too slow ones.

    Strong noise at low frequencies, or a drift, stands out so where it hides the signal.
    """
    record, frequency = task.record, task.frequency_hz
    whole = (record.end - record.valid_from) * record.dt_s * frequency
    periods = task.periods if window == "d30" else whole
    slow = record.quantity != "angle" and frequency < _SLOWEST_HZ
    if periods < 1.0 or (slow and periods < FEWEST_PERIODS):
        seen = f"{periods:.1f} periods of {frequency:.3g} Hz are the strongest feature: a drift or slow noise"
        raise RefusedError(Refusal.NO_SIGNAL, seen)


def _usable_sd(noise: NoiseModel, record: RingDownRecord) -> np.ndarray:
    """Standard deviations (channels,), kept above rounding so that noise-free records can be fitted."""
    sd = np.asarray(noise.sd, dtype=np.float64)
    if sd.shape != (record.channels,) or not all(0.0 <= one < math.inf for one in sd.tolist()):
        raise ValueError(f"noise.sd must be {record.channels} finite numbers >= 0, not {sd!r}")
    return np.maximum(sd, _smallest_sd(record))


def _smallest_sd(record: RingDownRecord) -> float:
    """Rounding of a noise-free record. A thousand samples, evenly spread, know the size of the signal well enough."""
    some = record.valid[:, :: max(1, record.valid.shape[1] // 1000)].ravel()
    return 1e-9 * math.sqrt(float(some @ some) / some.size)
