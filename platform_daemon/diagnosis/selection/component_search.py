"""Places where something may stand beside the signal: frequencies and decay times, found in what fits leave over."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
from scipy.fft import next_fast_len, rfft
from scipy.stats import gamma

from platform_daemon.estimation import MAINS_HZ, Array, Zones, is_mains, median_level, peak_shift, periodogram, sd_at

from ..effects.additive import LINE, MAINS, MAINS_TOLERANCE, side_mode, tone, transient
from ..effects.effect import Candidate
from ..regression.joint_fit import JointFit
from ..regression.prediction import unpredicted, window_of
from .significance import log_chance

_SURE = 1e-6  # chance of a line anywhere in a residual without one
_MOST_TONES = 12
_BETA = 8.0  # of the Kaiser window
_MARGIN_BINS, _SWEEP_MARGIN = 4.0, 0.002  # beside what the harmonics sweep through
_MISSED_HZ = 0.15  # by which a line of the mains may be misread
_SIDE_RATE_HZ = 15e3
_TAUS = 8
_SLOW = 0.3  # of the window: a decay time from which it may be no decay at all
_PEAKS = 2  # places offered per decay time and channel
_OFFERED = 8
_SHORTEST_TRANSIENT_S = 30e-6
_TRANSIENTS = 14


@dataclass(frozen=True)
class ShotResidual:
    """The residual of one shot at the full rate, (channels, n), freed from all that the refit holds, from time 0 on."""

    samples: Array
    level: Array  # (channels,) standard deviation of the noise
    rate_hz: float
    first: int


def shot_residuals(at: JointFit, pool: Executor) -> list[ShotResidual]:
    """Of all shots."""
    return list(pool.map(lambda k: _shot_residual(at, k), range(len(at.linear))))


def _shot_residual(at: JointFit, k: int) -> ShotResidual:
    shot = at.started[k].shot
    level = sd_at(shot.noise, np.array([at.states[k].dynamics.w / (2.0 * math.pi)]), shot.rate_hz)[:, 0]
    return ShotResidual(unpredicted(at, k), level, shot.rate_hz, window_of(at.started[k])[0])


def tones(at: JointFit, left: Sequence[ShotResidual]) -> list[Candidate]:
    """Lines in the residual's spectrum outside the zones of the harmonics: mains first, then others."""
    n = next_fast_len(max(x.samples.shape[1] for x in left), real=True)
    rate = left[0].rate_hz
    spectra = [x.level**-2.0 @ periodogram(x.samples, np.kaiser(x.samples.shape[1], _BETA), n) for x in left]
    power = np.sum(spectra, axis=0)
    grid = np.arange(power.size) * rate / n
    degrees = len(left) * left[0].samples.shape[0]
    edges = [0, *np.unique(np.geomspace(16, power.size, 40).astype(int))]
    power = power / median_level(power[None], edges)[0] * degrees
    bins = min(x.samples.shape[1] for x in left)
    threshold = float(gamma.isf(_SURE / bins, degrees))
    for d in (state.dynamics for state in at.states):
        zones = Zones.of_sweep(d.w, d.amplitude, relative=_SWEEP_MARGIN, margin_hz=_MARGIN_BINS * rate / bins)
        power[zones.holds(grid)] = 0.0
    power[grid < 3.0 * rate / bins] = 0.0
    found: list[float] = []
    while len(found) < _MOST_TONES and power.max() > threshold:
        peak = int(np.argmax(power))
        found.append((peak + peak_shift(power, peak)) * rate / n)
        power[max(0, peak - 6 * n // bins) : peak + 6 * n // bins + 1] = 0.0
    return _named(found, 0.5 * bins)


def _named(found: Sequence[float], trials: float) -> list[Candidate]:
    """Tones as candidates: multiples of the mains together, others one by one."""
    rest = list(found)
    candidates = []
    for mains in MAINS_HZ:
        mine = [f for f in rest if is_mains(f, relative=MAINS_TOLERANCE, missed_hz=_MISSED_HZ, mains_hz=(mains,))]
        # A single line at a multiple may be anything.
        if len(mine) > 1 or any(f < 1.5 * mains for f in mine):
            candidates.append(tone(MAINS, tuple(sorted(mine)), mains, trials))
            rest = [f for f in rest if f not in mine]
    return candidates + [tone(LINE, (f,), f, trials) for f in rest]


def side_modes(at: JointFit, left: Sequence[ShotResidual]) -> list[Candidate]:
    """Decaying oscillations, with a phase common to all shots or each its own."""
    rate = left[0].rate_hz
    block = max(1, int(rate / _SIDE_RATE_HZ))
    count = min(x.samples.shape[1] for x in left) // block
    means = [_blocks(x, block, count) for x in left]
    seconds, step = count * block / rate, block / rate
    time = left[0].first / rate + (np.arange(count) + 0.5 * (1.0 - 1.0 / block)) * step
    channels = means[0].shape[0]
    n = next_fast_len(2 * count, real=True)
    found = []
    fastest = 3.0 * 2.0 * math.pi / at.states[0].dynamics.w
    # What hardly decays within the window is a line.
    for tau in np.geomspace(fastest, 0.7 * seconds, _TAUS):
        fall = np.exp(-time / tau)
        norm = math.sqrt(0.5 * float(fall @ fall))
        transforms = np.stack([rfft(m * fall, n, axis=1) for m in means]) / norm
        trials = _TAUS * seconds / min(tau, seconds) * count / 2.0
        for shared, power in (
            (True, np.abs(transforms.sum(axis=0)) ** 2 / len(means)),
            (False, np.sum(np.abs(transforms) ** 2, axis=0)),
        ):
            found += _peaks(power, n * step, float(tau), channels, shared, trials, len(means))
    found.sort(key=lambda pair: pair[0])
    return _different([candidate for _, candidate in found], seconds)[:_OFFERED]


def steady_tones(at: JointFit, sides: Sequence[Candidate]) -> list[Candidate]:
    """Tones where oscillations hardly decay: too weak to stand out as lines."""
    seconds = float(at.started[0].time_s[-1])
    found: list[Candidate] = []
    for c in sides:
        f = c.detail.frequency_hz or 0.0
        if (c.detail.tau_s or 0.0) > _SLOW * seconds and all(abs(f - o.tones_hz[0]) > 1.0 / seconds for o in found):
            found.append(tone(LINE, (f,), f, c.trials))
    return found


def _different(candidates: Sequence[Candidate], seconds: float) -> list[Candidate]:
    """Without those that stand where a more surprising one of the same decay time does."""
    kept: list[Candidate] = []
    for c in candidates:
        f, tau = c.detail.frequency_hz or 0.0, c.detail.tau_s or seconds
        if not any(
            k.shared == c.shared and k.detail.axis == c.detail.axis and k.detail.tau_s == c.detail.tau_s
            and abs((k.detail.frequency_hz or 0.0) - f) < 1.0 / min(tau, seconds)
            for k in kept
        ):  # fmt: skip
            kept.append(c)
    return kept


def _blocks(left: ShotResidual, block: int, count: int) -> Array:
    """Block means over their noise, (channels, count)."""
    cut = left.samples[:, : block * count].reshape(left.samples.shape[0], count, block)
    return np.asarray(cut.mean(axis=2) * math.sqrt(block) / left.level[:, None])


def _peaks(
    power: Array, seconds: float, tau_s: float, channels: int, shared: bool, trials: float, shots: int
) -> list[tuple[float, Candidate]]:
    """The strongest places of one decay time, with the logarithms of their chances."""
    found = []
    bins = np.arange(power.shape[1])
    for channel in [*range(channels), None] if channels > 1 else [0]:
        row = (power.sum(axis=0) if channel is None else power[channel]).copy()
        degrees = (channels if channel is None else 1) * (1 if shared else shots)
        offered = None if shared and channels > 1 else channel
        row[:4] = 0.0
        width = max(4, int(seconds / tau_s))
        # What makes less than half a turn before it is gone is an offset that decays.
        row[bins / seconds * tau_s < 0.5] = 0.0
        for _ in range(_PEAKS):
            peak = int(np.argmax(row))
            place = (peak + peak_shift(row, peak)) / seconds
            # |F|^2 with this norm is a sum of two squares of noise, per channel.
            chance = log_chance(float(row[peak]), 2 * degrees, trials)
            candidate = side_mode(place, tau_s, offered, channels, shared=shared, trials=trials)
            found.append((chance, candidate))
            row[np.abs(bins - peak) <= width] = 0.0
    return found


def transients(at: JointFit) -> list[Candidate]:
    """Decaying offsets of any channel, at a grid of decay times; an encoder has no switch that leaves any."""
    if at.started[0].shot.record.quantity == "angle":
        return []
    channels = at.linear[0].seen.residual.shape[0]
    seconds = float(at.started[0].time_s[-1])
    shortest = max(_SHORTEST_TRANSIENT_S, 1.0 / at.started[0].shot.rate_hz)
    places = np.geomspace(shortest, 0.1 * seconds, _TRANSIENTS)
    return [transient(float(tau), None if channels > 1 else 0, channels, trials=1.0) for tau in places]
