"""What a moving parameter goes with: amplitude, peak speed or time; which simple law of it explains its motion best."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from platform_daemon.estimation import Array

Regressor = Literal["amplitude", "speed", "time"]
_POWERS = (-1.0, 1.0, 2.0)  # of amplitude and speed; -1: a loss that is dry friction in truth
_SETTLING = (0.05, 0.15, 0.5)  # time constants over the window
_CLOSE = 6.0  # fall of chi^2, and
_SHARE = 0.003  # share of the best law's, by which two laws are hardly told apart
_FREEDOM = 2.0  # fall of chi^2 that a degree of freedom is worth
_ENOUGH = 0.5  # of what any course would gain


@dataclass(frozen=True)
class Course:
    """A group of shots at the knots of its trace: time, amplitude and peak speed of the swing, (n,)."""

    time_s: Array
    amplitude: Array
    peak_speed: Array


@dataclass(frozen=True)
class TraceFit:
    """What a trace goes with.

    follows: the best and those that are hardly told from it; empty: no simple law of one of them.
    rises: the parameter grows from the beginning to the end.
    explained: what the best law gains over what any course would.
    merit: fall of chi^2 over the noise factor by the best law, or by any course if that is worth its freedom.
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
        @ (scale * np.linalg.lstsq(information * np.outer(scale, scale), scale * gradient, rcond=1e-10)[0])
        / noise_factor
    )
    order = sorted(gains, key=lambda n: -gains[n])
    best = gains[order[0]]
    explained = best / max(any_course, best, 1e-300)
    near = [n for n in gains if best - gains[n] < max(_CLOSE, _SHARE * best)]
    merit = max(best - _FREEDOM, any_course - _FREEDOM * gradient.size)
    return TraceFit(tuple(near) if explained > _ENOUGH else (), rising[order[0]], explained, merit)


def _laws(courses: Sequence[Course]) -> Iterator[tuple[Regressor, list[Array]]]:
    """Of each regressor: values at the knots, a row for each group."""
    tops = max(float(c.amplitude.max()) for c in courses), max(float(c.peak_speed.max()) for c in courses)
    for power in _POWERS:
        yield "amplitude", [np.maximum(c.amplitude / tops[0], 1e-6) ** power for c in courses]
        yield "speed", [np.maximum(c.peak_speed / tops[1], 1e-6) ** power for c in courses]
    longest = max(float(c.time_s[-1]) for c in courses)
    yield "time", [c.time_s / longest for c in courses]
    for share in _SETTLING:
        yield "time", [np.exp(-c.time_s / (share * longest)) for c in courses]
