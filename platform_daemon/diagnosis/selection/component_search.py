"""Search of the residual for additive effects: frequencies and decay times of tones, side modes and transients."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np
from scipy.fft import next_fast_len, rfft
from scipy.stats import gamma

from platform_daemon.diagnosis.effects.additive import LINE, MAINS, side_mode, tone, transient
from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.regression.joint_fit import JointFit, fit_jointly
from platform_daemon.diagnosis.regression.prediction import unpredicted, window_of
from platform_daemon.diagnosis.shots.shot import PreparedShot, whitening_for
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.noise.coloured import sd_at
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.screening.spectral_lines import (
    MAINS_HZ,
    Zones,
    is_mains,
    median_level,
    peak_shift,
    periodogram,
)

from .significance import log_chance

_LIMITS = THRESHOLDS.selection


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
    shot = at.prepared[k].shot
    level = sd_at(shot.noise, np.array([at.states[k].dynamics.w / (2.0 * math.pi)]), shot.rate_hz)[:, 0]
    return ShotResidual(unpredicted(at, k), level, shot.rate_hz, window_of(at.prepared[k])[0])


def tones(at: JointFit, residuals: Sequence[ShotResidual]) -> list[Candidate]:
    """Lines in the residual's spectrum outside the zones of the harmonics: mains first, then others.

    The periodograms of all shots and channels, each over its noise, are added, so that white noise has a chi-squared
    distribution in every bin (`degrees`: half its degrees of freedom).  The strongest bin above the threshold is a
    line; its neighbourhood is blanked, and the search goes on.  Far up, where the sweeps of neighbouring harmonics
    overlap and cover everything, a line is one that is much narrower than a sweep.
    """
    n = next_fast_len(max(x.samples.shape[1] for x in residuals), real=True)
    rate = residuals[0].rate_hz
    spectra = [
        x.level**-2.0 @ periodogram(x.samples, np.kaiser(x.samples.shape[1], _LIMITS.kaiser_beta), n) for x in residuals
    ]
    power = np.sum(spectra, axis=0)
    grid = np.arange(power.size) * rate / n
    degrees = len(residuals) * residuals[0].samples.shape[0]
    edges = [0, *np.unique(np.geomspace(_LIMITS.level_edges_from, power.size, _LIMITS.level_edges).astype(int))]
    power = power / median_level(power[None], edges)[0] * degrees
    bins = min(x.samples.shape[1] for x in residuals)
    threshold = float(gamma.isf(_LIMITS.line_chance / bins, degrees))
    reach = _LIMITS.blanked_bins * n // bins
    around = np.unique(np.append(np.arange(0, power.size, 2 * _LIMITS.narrow_reach * reach), power.size))
    whole, narrow = power.copy(), power > _LIMITS.narrow_ratio * median_level(power[None], around)[0]
    for d in (state.dynamics for state in at.states):
        zones = Zones.of_sweep(
            d.w, d.amplitude, relative=_LIMITS.sweep_share, margin_hz=_LIMITS.margin_bins * rate / bins
        )
        swept = zones.holds(grid)
        wide_hz = 2.0 * _LIMITS.narrow_reach * reach * rate / n
        from_order = max(_LIMITS.hiding_harmonics, zones.overlap_from, wide_hz / zones.width_hz)
        far = grid > from_order * zones.high_hz
        power[swept & (~far | ~narrow)] = 0.0
    power[grid < _LIMITS.lowest_bins * rate / bins] = 0.0
    found: list[float] = []
    while len(found) < _LIMITS.most_tones and power.max() > threshold:
        peak = int(np.argmax(power))
        found.append((peak + peak_shift(whole, peak)) * rate / n)
        power[max(0, peak - reach) : peak + reach + 1] = 0.0
    return _named(found, 0.5 * bins)


def _named(found: Sequence[float], trials: float) -> list[Candidate]:
    """Tones as candidates: multiples of the mains together, others one by one."""
    rest = list(found)
    candidates = []
    for mains in MAINS_HZ:
        mine = [
            f
            for f in rest
            if is_mains(
                f, relative=THRESHOLDS.effects.mains_share, missed_hz=_LIMITS.missed_mains_hz, mains_hz=(mains,)
            )
        ]
        # A single line at a multiple may be anything.
        if len(mine) > 1 or any(f < _LIMITS.single_mains_ratio * mains for f in mine):
            candidates.append(tone(MAINS, tuple(sorted(mine)), mains, trials))
            rest = [f for f in rest if f not in mine]
    return candidates + [tone(LINE, (f,), f, trials) for f in rest]


def side_modes(at: JointFit, residuals: Sequence[ShotResidual]) -> list[Candidate]:
    """Decaying oscillations, with a phase common to all shots or each its own."""
    rate = residuals[0].rate_hz
    block = max(1, int(rate / _LIMITS.side_rate_hz))
    count = min(x.samples.shape[1] for x in residuals) // block
    means = [_blocks(x, block, count) for x in residuals]
    seconds, step = count * block / rate, block / rate
    time = residuals[0].first / rate + (np.arange(count) + 0.5 * (1.0 - 1.0 / block)) * step
    channels = means[0].shape[0]
    n = next_fast_len(2 * count, real=True)
    found = []
    fastest = _LIMITS.fastest_decay_periods * 2.0 * math.pi / at.states[0].dynamics.w
    # What hardly decays within the window is a line.
    for tau in np.geomspace(fastest, _LIMITS.slowest_decay * seconds, _LIMITS.decay_times):
        fall = np.exp(-time / tau)
        norm = math.sqrt(0.5 * float(fall @ fall))
        transforms = np.stack([rfft(m * fall, n, axis=1) for m in means]) / norm
        trials = _LIMITS.decay_times * seconds / min(tau, seconds) * count / 2.0
        for shared, power in (
            (True, np.abs(transforms.sum(axis=0)) ** 2 / len(means)),
            (False, np.sum(np.abs(transforms) ** 2, axis=0)),
        ):
            found += _peaks(power, n * step, float(tau), channels, shared, trials, len(means))
    found.sort(key=lambda pair: pair[0])
    return _different([candidate for _, candidate in found], seconds)[: _LIMITS.offered_side_modes]


def steady_tones(at: JointFit, sides: Sequence[Candidate]) -> list[Candidate]:
    """Tones where oscillations hardly decay: too weak for a spectral line."""
    seconds = float(at.prepared[0].time_s[-1])
    found: list[Candidate] = []
    for c in sides:
        f = c.detail.frequency_hz or 0.0
        if (c.detail.tau_s or 0.0) > _LIMITS.steady_decay * seconds and all(
            abs(f - o.tones_hz[0]) > 1.0 / seconds for o in found
        ):
            found.append(tone(LINE, (f,), f, c.trials))
    return found


def _different(candidates: Sequence[Candidate], seconds: float) -> list[Candidate]:
    """Without those at the place of a more significant one of the same decay time."""
    kept: list[Candidate] = []
    for c in candidates:
        f, tau = c.detail.frequency_hz or 0.0, c.detail.tau_s or seconds
        if not any(
            k.shared == c.shared
            and k.detail.axis == c.detail.axis
            and k.detail.tau_s == c.detail.tau_s
            and abs((k.detail.frequency_hz or 0.0) - f) < 1.0 / min(tau, seconds)
            for k in kept
        ):
            kept.append(c)
    return kept


def _blocks(residuals: ShotResidual, block: int, count: int) -> Array:
    """Block means over their noise, (channels, count)."""
    cut = residuals.samples[:, : block * count].reshape(residuals.samples.shape[0], count, block)
    return np.asarray(cut.mean(axis=2) * math.sqrt(block) / residuals.level[:, None])


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
        row[: _LIMITS.blanked_side_bins] = 0.0
        width = max(_LIMITS.blanked_side_bins, int(seconds / tau_s))
        # An oscillation of less than half a period per decay time is an offset that decays.
        row[bins / seconds * tau_s < _LIMITS.least_turns] = 0.0
        for _ in range(_LIMITS.peaks_per_decay):
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
    if at.prepared[0].shot.record.quantity == "angle":
        return []
    channels = at.linear[0].linearisation.residual.shape[0]
    seconds = float(at.prepared[0].time_s[-1])
    shortest = max(_LIMITS.shortest_transient_s, 1.0 / at.prepared[0].shot.rate_hz)
    places = np.geomspace(shortest, _LIMITS.longest_transient * seconds, _LIMITS.transient_times)
    return [transient(float(tau), None if channels > 1 else 0, channels, trials=1.0) for tau in places]


def with_tone_free_noise(base: JointFit, pool: Executor) -> JointFit:
    """The joint fit again, with noise spectra bridged at the tones; as it is where there are none.

    The quiet parts that the noise is estimated from contain the tones too. Counted as noise these would hide, and chi^2
    per degree of freedom would fall below 1 once they are explained.
    """
    found = np.array([f for c in tones(base, shot_residuals(base, pool)) for f in c.tones_hz])
    if not found.size:
        return base
    return fit_jointly(_quieter(base.prepared, found), base.hypothesis, pool, base.states)


def _quieter(prepared: Sequence[PreparedShot], tones_hz: Array) -> list[PreparedShot]:
    out = []
    for s in prepared:
        shot = replace(s.shot, noise=s.shot.noise.without_tones(tones_hz))
        out.append(replace(s, shot=shot, white=whitening_for(shot, s.grids, s.state.dynamics.w / (2.0 * math.pi))))
    return out
