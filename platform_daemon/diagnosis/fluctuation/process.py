"""The random process that a course follows: its size and its correlation time, by their marginal likelihood.

x(t) over what a size of 1 stands for (the mean friction, or 1 Hz) is normal with standard deviation s and the
correlation exp(-|t| / tau) (Ornstein and Uhlenbeck).  With the shot's own parameters eliminated a shot gives
information A and gradient g of the knots; to first order, and but for a constant,
-2 log L = log det(1 + A P) - g^T (A + P^-1)^-1 g, with P = P(s, tau).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from platform_daemon.diagnosis.selection.significance import LEVEL, log_chance
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array

_LIMITS = THRESHOLDS.fluctuation


@dataclass(frozen=True, kw_only=True)
class CourseProcess:
    """size: standard deviation over the mean friction, or in Hz; tau_s: correlation time."""

    size: float
    tau_s: float

    def near(self, other: CourseProcess) -> bool:
        """True if size and correlation time hardly differ."""
        sizes, times = math.log(self.size / other.size), math.log(self.tau_s / other.tau_s)
        return max(abs(sizes), abs(times)) < _LIMITS.settled_log

    def root(self, time_s: Array, unit: float) -> Array:
        """Lower triangle L (k, k), with L L^T the covariance of knots at these times, (rad/s^2)^2.

        unit: what a size of 1 stands for, rad/s^2.
        """
        correlation = np.exp(-np.abs(time_s[:, None] - time_s[None]) / self.tau_s)
        return np.asarray(self.size * unit * np.linalg.cholesky(correlation))


@dataclass(frozen=True, kw_only=True)
class CourseInformation:
    """What one shot tells about its course: times of the knots, what a size of 1 stands for, A (k, k),
    g (k,)."""

    time_s: Array
    unit: float
    information: Array
    gradient: Array

    @classmethod
    def of_one_course(cls, shots: Sequence[CourseInformation]) -> CourseInformation:
        """What shots tell about a course that they all have in common, as a law of angle, speed or time makes it."""
        return cls(
            time_s=shots[0].time_s,
            unit=shots[0].unit,
            information=np.sum([s.information for s in shots], axis=0),
            gradient=np.sum([s.gradient for s in shots], axis=0),
        )

    def log_likelihood(self, process: CourseProcess) -> float:
        """Over that of no fluctuation."""
        root = process.root(self.time_s, self.unit)
        values, vectors = np.linalg.eigh(root.T @ self.information @ root)
        along = vectors.T @ (root.T @ self.gradient)
        values = np.maximum(values, 0.0)
        return -0.5 * float(np.sum(np.log1p(values)) - np.sum(along**2 / (1.0 + values)))


@dataclass(frozen=True, kw_only=True)
class LikeliestProcess:
    """process: the likeliest one; log_covariance: (2, 2) of log size and log tau; log_likelihood: over none."""

    process: CourseProcess
    log_covariance: Array
    log_likelihood: float

    @property
    def log_size_std(self) -> float:
        """Standard deviation of the logarithm of the size."""
        return math.sqrt(self.log_covariance[0, 0])

    @property
    def log_tau_std(self) -> float:
        """Of that of the correlation time."""
        return math.sqrt(self.log_covariance[1, 1])

    def neighbours(self) -> list[tuple[CourseProcess, float]]:
        """The process moved along each axis of its errors, to where it fluctuates more slowly, and how many such moves
        a standard deviation has.

        A direction of which the data tell little moves by less than its standard deviation.
        """
        found = []
        values, axes = np.linalg.eigh(self.log_covariance)
        for std, axis in zip(np.sqrt(values), axes.T, strict=True):
            moved = min(float(std), _LIMITS.furthest_log)
            size, tau_s = np.exp(math.copysign(moved, axis[1]) * axis) * (self.process.size, self.process.tau_s)
            found.append((CourseProcess(size=float(size), tau_s=float(tau_s)), float(std) / moved))
        return found

    @property
    def sure(self) -> bool:
        """True for a fluctuation that is there beyond chance."""
        return log_chance(2.0 * self.log_likelihood, 2) < LEVEL


def likeliest_process(shots: Sequence[CourseInformation], start: CourseProcess, largest: float) -> LikeliestProcess:
    """Of shots that share one process; largest: size that is sought."""
    longest = max(float(s.time_s[-1]) for s in shots)
    shortest = max(float(s.time_s[1]) for s in shots)
    lower = np.log([_LIMITS.least_size, shortest])
    upper = np.log([largest, longest])

    def loss(x: Array) -> float:
        process = CourseProcess(size=math.exp(x[0]), tau_s=math.exp(x[1]))
        return -sum(s.log_likelihood(process) for s in shots)

    first = np.clip(np.log([start.size, start.tau_s]), lower, upper)
    found = minimize(loss, first, method="Nelder-Mead", bounds=list(zip(lower, upper, strict=True)))
    at, h = found.x, _LIMITS.curvature_step
    bend = np.empty((2, 2))
    for a, b in ((0, 0), (0, 1), (1, 1)):
        da, db = h * np.eye(2)[a], h * np.eye(2)[b]
        bend[a, b] = bend[b, a] = (
            loss(at + da + db) - loss(at + da - db) - loss(at - da + db) + loss(at - da - db)
        ) / (4.0 * h * h)
    best = CourseProcess(size=math.exp(at[0]), tau_s=math.exp(at[1]))
    values, axes = np.linalg.eigh(bend)
    known = np.maximum(values, _LIMITS.widest_log**-2)  # a direction that the data do not determine is wide
    covariance = axes / known @ axes.T
    return LikeliestProcess(process=best, log_covariance=np.asarray(covariance), log_likelihood=-float(found.fun))
