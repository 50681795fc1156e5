"""Residuals with the declared model and with the named effects, for figures and tables."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from platform_daemon.estimation.sliding_window import SlidingFit

from .diagnosis_result import Diagnosis
from .findings.residual_analysis import (
    ResidualAnalysis,
    Scatter,
    analyse_residual,
    scatter,
    sliding_windows,
    typical_shot,
)
from .shots.shot import PreparedShot
from .shots.thread_pool import shot_pool
from .thresholds import THRESHOLDS


@dataclass(frozen=True)
class SlidingComparison:
    """Fits along one shot with the declared model and with the named effects."""

    shot: str
    before: SlidingFit
    after: SlidingFit


@dataclass(frozen=True, kw_only=True)
class MeasuredShot:
    """How a shot was measured: window in s, sampling rate in Hz, where its noise comes from, the noise's median
    standard deviation per sample in the record's unit."""

    name: str
    window_s: float
    rate_hz: float
    noise_source: str
    noise_sd: float


@dataclass(frozen=True)
class ResidualComparison:
    """The residual with the declared model (before) and with the named effects (after).

    Attributes:
        unit: of the records; f_nat_hz: mean over the shots.
        shots: (before, after) of the first and of a typical shot, which may be the same one.
        sliding: None where the typical shot is too short.
        scatter_before, scatter_after: every parameter from shot to shot; none for a single shot.
        measured: every shot that was used.
    """

    unit: str
    f_nat_hz: float
    shots: tuple[tuple[ResidualAnalysis, ResidualAnalysis], ...]
    sliding: SlidingComparison | None
    scatter_before: tuple[Scatter, ...]
    scatter_after: tuple[Scatter, ...]
    measured: tuple[MeasuredShot, ...]


def compare_residuals(found: Diagnosis) -> ResidualComparison:
    """Analyse the residuals before and after; the fits of sliding windows take about a second."""
    before, after = found.found.base, found.final
    typical = typical_shot(before)
    with shot_pool() as pool:
        chosen = dict.fromkeys([0, typical])
        pairs = tuple(pool.map(lambda k: (analyse_residual(before, k), analyse_residual(after, k)), chosen))
        slides = pool.map(lambda at: sliding_windows(at, typical), (before, after))
        courses = scatter(before, pool), scatter(after, pool)
    return ResidualComparison(
        unit=found.shots[0].unit,
        f_nat_hz=float(np.mean([s.dynamics.w for s in before.states])) / (2.0 * math.pi),
        shots=pairs,
        sliding=_sliding(before.prepared[typical].shot.name, *slides),
        scatter_before=courses[0],
        scatter_after=courses[1],
        measured=tuple(map(_measured, after.prepared)),
    )


def _sliding(shot: str, before: SlidingFit | None, after: SlidingFit | None) -> SlidingComparison | None:
    if before is None or after is None or len(before.windows) < THRESHOLDS.findings.fewest_windows:
        return None
    return SlidingComparison(shot, before, after)


def _measured(prepared: PreparedShot) -> MeasuredShot:
    shot, time = prepared.shot, prepared.time_s
    window_s, noise_sd = float(time[-1] - time[0]), float(np.median(shot.noise.sd))
    return MeasuredShot(
        name=shot.name, window_s=window_s, rate_hz=shot.rate_hz, noise_source=shot.noise.source, noise_sd=noise_sd
    )
