"""Samples that repeat the one before: a camera or a logger that had no new value delivers the old one again.

In a swing with noise two neighbours are equal by chance only if they agree to the last digit of the record.  How many
should be, the nearly equal ones tell: of n pairs that differ by no more than d digits, but do differ, about n / (2 d)
would be equal, or up to twice as many, where neighbours differ by few digits.  The digit is another one in each decade
of the angle, where a text has so many significant digits.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import make_interp_spline

from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.numerics.arrays import Array, IntArray

from .data_integrity import DataDefect

_LIMITS = THRESHOLDS.shots


def without_stale_samples(shots: Sequence[DiagnosisShot]) -> tuple[list[DiagnosisShot], list[DataDefect]]:
    """Shots of an angle with their stale samples interpolated, and what was found in each of them."""
    found, defects = [], []
    for k, shot in enumerate(shots):
        stale = stale_samples(shot.record.samples[0, shot.record.valid_from : shot.record.end])
        found.append(_interpolated(shot, stale))
        if stale.size:
            first = shot.record.valid_from + int(stale[0])
            where = f"{shot.name}: {stale.size} samples repeat the one before and are interpolated, the first {first}"
            defects.append(DataDefect(id="stale_samples", where=where, shot=k, at=first, value=float(stale.size)))
    return found, defects


def stale_samples(angle: Array) -> IntArray:
    """Numbers of the samples that are equal to the one before and should not be; empty if there are none.

    angle: (n,) in any unit; samples that are no number are no repeats.
    """
    steps = np.abs(np.diff(angle))
    equal = np.flatnonzero(steps == 0.0) + 1
    by_chance = _by_chance(np.maximum(np.abs(angle[1:]), np.abs(angle[:-1])), steps)
    # Runs: a value that stands for many samples is that of a rotor at rest, or of a record that is held.
    ends = np.flatnonzero(np.diff(equal, append=angle.size + 2) > 1)
    longest = int(np.max(np.diff(ends, prepend=-1), initial=0))
    many = equal.size > _LIMITS.stale_ratio * by_chance + _LIMITS.stale_sigma * math.sqrt(by_chance + 1.0)
    few = equal.size < _LIMITS.most_stale_share * angle.size and longest <= _LIMITS.longest_stale
    return equal if many and few else np.zeros(0, dtype=np.int64)


def _by_chance(sizes: Array, steps: Array) -> float:
    """How many steps (n,) would be 0 by chance; sizes: (n,) of the angle there, whose decades have digits of their own.

    Where the steps are no multiples of the smallest one, that is no digit, and chance makes no two alike.
    """
    moving = steps > 0.0
    decades = np.floor(np.log10(np.where(moving, sizes, 1.0)))
    found = 0.0
    for decade in np.unique(decades[moving]):
        inside = steps[moving & (decades == decade)]
        digits = inside[inside <= (_LIMITS.stale_digits + 0.5) * inside.min()] / inside.min()
        if np.abs(digits - np.round(digits)).mean() < _LIMITS.stale_whole:
            found += digits.size / (2.0 * _LIMITS.stale_digits)
    return found


def _interpolated(shot: DiagnosisShot, stale: IntArray) -> DiagnosisShot:
    """The shot with the cubic spline through the other samples in the place of stale ones."""
    if not stale.size:
        return shot
    record = shot.record
    places = np.arange(record.samples.shape[1])
    good = np.ones(places.size, dtype=bool)
    good[record.valid_from + stale] = False
    samples = record.samples.copy()
    good &= np.isfinite(samples[0])
    bad = record.valid_from + stale
    samples[0, bad] = make_interp_spline(places[good], samples[0, good])(bad)
    mended = replace(record, samples=samples)
    noise = estimate_noise(mended) if shot.noise.of_swings else shot.noise
    return replace(shot, record=mended, noise=noise)
