"""Linear equations of all parameters that may move, for groups of shots of like amplitude."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from platform_daemon.diagnosis.regression.information import solved
from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.regression.linearised_shot import LinearisedShot
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array

from .knot_responses import KnotResponses, SlowMotion, knot_responses, moving_parameters_of
from .trace_shapes import Course

_LIMITS = THRESHOLDS.findings


@dataclass(frozen=True)
class ResidualNoise:
    """The factor by which gains are divided, and the number of independent values that it is known from."""

    factor: float
    values: float


class TraceEquations:
    """Steps between knots as unknowns: parameter by parameter, group by group.

    Attributes:
        moving: the parameters. groups: numbers of the shots that start alike; courses: of each group; shots: responses
        of each shot of each group.
    """

    def __init__(self, at: JointFit, pool: Executor) -> None:
        self._at, self._pool = at, pool
        self._known: dict[tuple[int, ...], ResidualNoise] = {}
        quantity = at.prepared[0].shot.record.quantity
        self.moving = moving_parameters_of(at.hypothesis.model, at.states[0], quantity)
        self.groups = _groups([abs(s.dynamics.amplitude) for s in at.states])
        self._knots = [self._knots_of(g) for g in self.groups]
        which = [(k, n) for n, group in enumerate(self.groups) for k in group]
        answers = list(pool.map(lambda pair: self._one(*pair), which))
        self.shots = [[r for r, (_, n) in zip(answers, which, strict=True) if n == m] for m in range(len(self._knots))]
        self.courses = [self._course(n) for n in range(len(self.groups))]
        self._information, self._gradient = self._summed()

    def _knots_of(self, group: Sequence[int]) -> Array:
        at = self._at
        begin = min(float(at.prepared[k].time_s[0]) for k in group)
        end = max(float(at.prepared[k].time_s[-1]) for k in group)
        periods = (end - begin) * at.states[group[0]].dynamics.w / (2.0 * math.pi)
        return np.linspace(begin, end, int(min(max(0.5 * periods, _LIMITS.fewest_knots), _LIMITS.most_knots)))

    def _one(self, k: int, group: int) -> KnotResponses:
        at = self._at
        return knot_responses(at.prepared[k], at.linear[k], at.hypothesis.model, self.moving, self._knots[group])

    def _course(self, group: int) -> Course:
        return mean_course(self._knots[group], [r.motion for r in self.shots[group]])

    def _summed(self) -> tuple[Array, Array]:
        """Of the steps between knots: parameter by parameter, group by group."""
        sizes = [knots.size - 1 for knots in self._knots]
        each, count = sum(sizes), len(self.moving)
        information, gradient = np.zeros((count * each, count * each)), np.zeros(count * each)
        begin = 0
        for size, shots in zip(sizes, self.shots, strict=True):
            to_knots = np.kron(np.eye(count), stairs(size))
            where = np.concatenate([np.arange(begin, begin + size) + m * each for m in range(count)])
            for r in shots:
                information[np.ix_(where, where)] += to_knots.T @ r.information @ to_knots
                gradient[where] += to_knots.T @ r.gradient
            begin += size
        return information, gradient

    def _places(self, m: int) -> np.ndarray:
        each = self._gradient.size // len(self.moving)
        return np.arange(m * each, (m + 1) * each)

    def schur_complement(self, m: int, others: Sequence[int]) -> tuple[Array, Array]:
        """Information and gradient of a parameter's steps, those of others eliminated."""
        mine = self._places(m)
        matrix, gradient = self._information[np.ix_(mine, mine)], self._gradient[mine]
        if not others:
            return matrix, gradient
        known = np.concatenate([self._places(o) for o in others])
        cross = self._information[np.ix_(known, mine)]
        within = solved(self._information[np.ix_(known, known)], np.column_stack([cross, self._gradient[known]]))
        return matrix - cross.T @ within[:, :-1], gradient - cross.T @ within[:, -1]

    def gain(self, which: Sequence[int]) -> float:
        """Fall of chi^2 if these parameters may take any course."""
        if not which:
            return 0.0
        places = np.concatenate([self._places(m) for m in which])
        gradient = self._gradient[places]
        return float(gradient @ solved(self._information[np.ix_(places, places)], gradient))

    def residual_noise(self, which: Sequence[int]) -> ResidualNoise:
        """If these parameters move: as the joint fit's noise factor, from what their best course leaves."""
        key = tuple(sorted(which))
        if key not in self._known:
            self._known[key] = self._residual_noise(key)
        return self._known[key]

    def _residual_noise(self, which: tuple[int, ...]) -> ResidualNoise:
        at, places = self._at, sum(self._places(m).size for m in which)
        excess = max(1.0, (at.chi2 - self.gain(which)) / max(at.dof - places, 1.0))
        if excess < THRESHOLDS.regression.noise_chi2_per_dof:
            return ResidualNoise(excess, at.dof - places)
        rests = list(self._pool.map(lambda pair: pair[0].after_trace(*pair[1:]), self._traces(which)))
        chi2 = sum(r.chi2 for r in rests)
        samples = sum(r.chi2 * r.samples_per_value for r in rests) / chi2
        return ResidualNoise(max(1.0, chi2 / at.dof) * samples, at.dof / samples - places)

    def _traces(self, which: Sequence[int]) -> list[tuple[KnotResponses, LinearisedShot, Array, Array]]:
        """Of each shot: responses, linearised shot, instants, and the best course of these parameters (k,)."""
        steps = np.zeros(self._gradient.size)
        if which:
            places = np.concatenate([self._places(m) for m in which])
            steps[places] = solved(self._information[np.ix_(places, places)], self._gradient[places])
        by_parameter, found, begin = steps.reshape(len(self.moving), -1), [], 0
        for group, course, shots in zip(self.groups, self.courses, self.shots, strict=True):
            end = begin + course.time_s.size - 1
            trace = (by_parameter[:, begin:end] @ stairs(end - begin).T).ravel()
            begin = end
            at = self._at
            found += [(r, at.linear[k], at.prepared[k].time_s, trace) for k, r in zip(group, shots, strict=True)]
        return found


def mean_course(knots: Array, motions: Sequence[SlowMotion]) -> Course:
    """Amplitude and peak speed at the knots (n,) in s, means over the shots that last so long.

    They are read off the motion, so that none is beyond what the swing had: a spline through a swing that comes to rest
    overshoots.
    """

    # A block more than there is: the last knot may be behind the last edge by a rounding.
    lasts = np.stack([knots < 2.0 * m.time_s[-1] - m.time_s[-2] for m in motions])

    def mean(rows: Sequence[Array]) -> Array:
        read = [np.interp(knots, m.time_s, row) for m, row in zip(motions, rows, strict=True)]
        return np.asarray(np.average(read, axis=0, weights=lasts))

    return Course(knots, mean([m.amplitude for m in motions]), mean([m.peak_speed for m in motions]))


def stairs(size: int) -> Array:
    """From steps (size,) to values at the knots (size + 1,); 0 at the first."""
    return np.vstack([np.zeros(size), np.tril(np.ones((size, size)))])


def _groups(amplitudes: Sequence[float]) -> list[list[int]]:
    """Shots of like amplitude, the largest first."""
    order = sorted(range(len(amplitudes)), key=lambda k: -amplitudes[k])
    groups = [[order[0]]]
    for k in order[1:]:
        apart = amplitudes[groups[-1][0]] > _LIMITS.group_ratio * amplitudes[k]
        if apart and len(groups) < _LIMITS.most_groups:
            groups.append([k])
        else:
            groups[-1].append(k)
    return groups
