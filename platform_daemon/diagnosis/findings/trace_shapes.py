"""The simple law of amplitude, peak speed or time that a moving parameter follows best."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array

_LIMITS = THRESHOLDS.findings
Regressor = Literal["amplitude", "speed", "time"]


@dataclass(frozen=True)
class Course:
    """A group of shots at the knots of its trace: time, amplitude and peak speed of the swing, (n,)."""

    time_s: Array
    amplitude: Array
    peak_speed: Array


@dataclass(frozen=True, kw_only=True)
class TraceFit:
    """The regressors that a trace follows.

    follows: the best one and those that explain nearly as much; empty if no simple law of them does.
    rises: the parameter grows from the beginning to the end.
    explained: what the best law gains over what any course would.
    merit: fall of chi^2 over the noise factor by the best law, or by a free course, less a penalty per parameter.
    """

    follows: tuple[Regressor, ...]
    rises: bool
    explained: float
    merit: float


def best_shapes(information: Array, gradient: Array, noise_factor: float, courses: Sequence[Course]) -> TraceFit:
    """Laws that are constant in the strength and common to all groups; information, gradient: of the steps."""
    gains: dict[Regressor, float] = {}
    rising: dict[Regressor, bool] = {}
    for name, values in _laws(courses):
        steps = np.concatenate([np.diff(v) for v in values])
        slope = float(steps @ gradient)
        gain = slope**2 / max(float(steps @ information @ steps), 1e-300) / noise_factor
        if gain > gains.get(name, -1.0):
            gains[name], rising[name] = gain, slope * sum(float(v[-1] - v[0]) for v in values) > 0.0
    scale = 1.0 / np.sqrt(np.maximum(np.diag(information), 1e-300))
    any_course = float(
        gradient
        @ (
            scale
            * np.linalg.lstsq(information * np.outer(scale, scale), scale * gradient, rcond=_LIMITS.course_rank)[0]
        )
        / noise_factor
    )
    order = sorted(gains, key=lambda n: -gains[n])
    best = gains[order[0]]
    explained = best / max(any_course, best, 1e-300)
    near = [n for n in gains if best - gains[n] < max(_LIMITS.alike_chi2, _LIMITS.alike_share * best)]
    merit = max(best - _LIMITS.chi2_per_freedom, any_course - _LIMITS.chi2_per_freedom * gradient.size)
    return TraceFit(
        follows=tuple(near) if explained > _LIMITS.law_share else (),
        rises=rising[order[0]],
        explained=explained,
        merit=merit,
    )


def _laws(courses: Sequence[Course]) -> Iterator[tuple[Regressor, list[Array]]]:
    """Of each regressor: values at the knots, a row for each group."""
    tops = max(float(c.amplitude.max()) for c in courses), max(float(c.peak_speed.max()) for c in courses)
    for power in _LIMITS.law_powers:
        yield "amplitude", [np.maximum(c.amplitude / tops[0], _LIMITS.least_ratio) ** power for c in courses]
        yield "speed", [np.maximum(c.peak_speed / tops[1], _LIMITS.least_ratio) ** power for c in courses]
    longest = max(float(c.time_s[-1]) for c in courses)
    yield "time", [c.time_s / longest for c in courses]
    for share in _LIMITS.law_settling:
        yield "time", [np.exp(-c.time_s / (share * longest)) for c in courses]
