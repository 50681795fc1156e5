"""What is to be fitted, whichever model does it: a screened record, its noise, and the samples of a window."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from .least_squares.problem import FitProblem
from .noise.model import NoiseModel, estimate_noise
from .numerics.arrays import Array
from .record import RingDownRecord
from .refusal import Refusal, RefusedError
from .screening.screening import FEWEST_PERIODS, refuse_few_periods, refuse_few_swings, screen
from .screening.two_resonators import refuse_two_lines
from .screening.windows import SampleRange, Window, select_window
from .thresholds import THRESHOLDS

LIMITS = THRESHOLDS.screening


@dataclass(frozen=True, kw_only=True)
class PreparedRecord:
    """A record ready to be fitted: screened, with its noise, and the samples of a window.

    Attributes:
        record: all samples.
        noise: its model; noise_sd: (channels,) standard deviation of a sample, kept above rounding.
        chosen: the samples that are fitted, and notes about them.
        frequency_hz: of the oscillation at the beginning.
        fixed: values of parameters that are not fitted, by public name.
        noise_seconds: what the measurement of the noise took.
        doubts: warnings of the result that are known before the fit is judged.
    """

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

    def at_level(self, ratio: float, source: str) -> PreparedRecord:
        """The record with so many times the noise, but no less than rounding makes."""
        sd = np.maximum(self.noise_sd * ratio, _smallest_sd(self.record))
        return replace(self, noise=self.noise.at_level(ratio, source), noise_sd=sd)

    def with_white_noise(self, sd: float, source: str) -> PreparedRecord:
        """The record with white noise of this standard deviation in every channel."""
        every = np.full(self.record.channels, sd)
        noise = replace(NoiseModel.white(every, self.record.sampling_rate_hz), source=source)
        return replace(self, noise=noise, noise_sd=np.maximum(every, _smallest_sd(self.record)))

    def degrees(self, problem: FitProblem) -> int:
        """Degrees of freedom of the residual."""
        return self.record.channels * self.samples - int(np.count_nonzero(problem.free))


def prepare_record(
    record: RingDownRecord, window: Window, noise: NoiseModel | None, fixed: Mapping[str, float]
) -> PreparedRecord:
    """Screen the record, measure its noise, choose the samples.

    Raises:
        RefusedError: unusable samples, no oscillation, or too few periods in the window.
        ValueError: a noise of the wrong shape, negative or not finite.
    """
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
    prepared = PreparedRecord(
        record=record,
        noise=noise,
        noise_sd=sd,
        chosen=chosen,
        frequency_hz=line.frequency_hz,
        fixed=fixed,
        noise_seconds=noise_seconds,
    )
    if prepared.periods < LIMITS.few_periods and record.quantity != "angle":
        seen = record.samples[:, chosen.first : chosen.last]
        counted = counted_periods(seen, dt_s=record.dt_s, frequency_hz=line.frequency_hz)
        prepared = replace(prepared, frequency_hz=counted / (prepared.samples * record.dt_s))
    try:
        _refuse_slow_change(prepared, window)
        refuse_few_periods(prepared.samples * record.dt_s, prepared.frequency_hz)
    except RefusedError:
        # A beat can be why so few periods came before the decay to 30 %.
        if window == "d30" and record.quantity != "angle" and line.frequency_hz > LIMITS.slowest_hz:
            refuse_two_lines(record, line.frequency_hz, sd)
        raise
    return prepared


def _refuse_slow_change(prepared: PreparedRecord, window: Window) -> None:
    """Refuse what is no oscillation of a resonator: it lasts for less than a period, or for a few far too slow ones.

    Strong noise at low frequencies, or a drift, is the strongest feature where it hides the signal.

    Raises RefusedError.
    """
    # D30 ends with the decay, so its periods count; another window may be short by choice: those of the record count.
    record, frequency = prepared.record, prepared.frequency_hz
    whole = (record.end - record.valid_from) * record.dt_s * frequency
    periods = prepared.periods if window == "d30" else whole
    slow = record.quantity != "angle" and frequency < LIMITS.slowest_hz
    if periods < 1.0 or (slow and periods < FEWEST_PERIODS):
        strongest = f"{periods:.1f} periods of {frequency:.3g} Hz are the strongest feature"
        seen = f"{strongest}: a drift, slow noise, or a time in another unit"
        raise RefusedError(Refusal.NO_SIGNAL, seen)


def _usable_sd(noise: NoiseModel, record: RingDownRecord) -> np.ndarray:
    """Standard deviations (channels,), kept above rounding so that noise-free records can be fitted."""
    sd = np.asarray(noise.sd, dtype=np.float64)
    if sd.shape != (record.channels,) or not all(0.0 <= one < math.inf for one in sd.tolist()):
        raise ValueError(f"noise.sd must be {record.channels} finite numbers >= 0, not {sd!r}")
    return np.maximum(sd, _smallest_sd(record))


def _smallest_sd(record: RingDownRecord) -> float:
    """Rounding of a noise-free record. A thousand samples, evenly spread, know the size of the signal well enough."""
    some = record.valid[:, :: max(1, record.valid.shape[1] // LIMITS.rounding_samples)].ravel()
    return LIMITS.rounding_share * math.sqrt(float(some @ some) / some.size)


def counted_periods(y: Array, *, dt_s: float, frequency_hz: float) -> float:
    """Periods in samples (channels, n), from the swings of their strongest combination.

    frequency_hz: an upper estimate; sets over how many samples noise is averaged.
    """
    block = max(1, int(1.0 / (LIMITS.counted_points_per_period * frequency_hz * dt_s)))
    n = y.shape[1] // block
    if n == 0:
        return y.shape[1] * dt_s * frequency_hz
    means = y[:, : n * block].reshape(y.shape[0], n, block).mean(axis=2)
    means -= means.mean(axis=1, keepdims=True)
    strongest = np.linalg.eigh(means @ means.T)[1][:, -1]
    turns = _turns(strongest @ means)
    if turns.size < 3:
        return 0.5 * turns.size
    return float(n * (turns.size - 1) / (2.0 * (turns[-1] - turns[0])))


def _turns(s: Array) -> Array:
    """Where s (n,) passes from one side to the other, fractional samples: between half its height there and back."""
    sides = np.where(np.abs(s) > LIMITS.counted_level_share * np.abs(s).max(), np.sign(s), 0.0)
    places = np.flatnonzero(sides)
    changes = np.flatnonzero(np.diff(sides[places]))
    return np.asarray(0.5 * (places[changes] + places[changes + 1]))
