"""Steady tones and drift fitted together with the ring-down, in linear least squares over all samples.

Every channel gets its own cos, sin and polynomial columns Z. Taking them out of the moments, G - Gbz Gzz^-1 Gzb and
so on, turns the normal equations of the ring-down into those of the joint problem: the estimates are unbiased by what
is removed, and their covariance knows of it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import legendre

from platform_daemon.estimation.moments.workspace import Moments
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.direct import Trajectory
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.thresholds import THRESHOLDS

from .gauss_newton import FitState, gauss_newton_step
from .noise_weighting import harmonic_sd, weighted_normal
from .problem import FitProblem, Minimum
from .public_parameters import by_convention

LIMITS = THRESHOLDS.least_squares


@dataclass(frozen=True, kw_only=True)
class Nuisance:
    """What is fitted together with a ring-down over samples first .. last-1.

    Attributes:
        tones_hz: (tones,) frequencies.
        degree: of the polynomial, 0: the offset only, which the fit has anyway.
    """

    tones_hz: Array
    degree: int
    first: int
    last: int

    @property
    def size(self) -> int:
        """Columns per channel."""
        return 2 * int(self.tones_hz.size) + self.degree

    def columns(self, begin: int, end: int, dt_s: float) -> Array:
        """cos and sin of every tone, then Legendre polynomials of degree 1 and up, (size, end - begin)."""
        i = np.arange(begin, end)
        phase = 2.0 * np.pi * np.outer(self.tones_hz, i * dt_s)
        x = (2.0 * i - (self.first + self.last - 1)) / max(self.last - self.first - 1, 1)
        return np.concatenate([np.cos(phase), np.sin(phase), legendre.legvander(x, self.degree).T[1:]])


@dataclass(frozen=True)
class NuisanceMoments:
    """Scalar products of the nuisance columns Z.

    with_basis (z, b), with_data (z, channels), with_themselves (z, z).
    """

    with_basis: Array
    with_data: Array
    with_themselves: Array

    def without(self, moments: Moments) -> Moments:
        """Moments of what is left when the columns are fitted too."""
        of_basis = np.linalg.solve(self.with_themselves, self.with_basis)
        of_data = np.linalg.solve(self.with_themselves, self.with_data)
        return replace(
            moments,
            gram=moments.gram - self.with_basis.T @ of_basis,
            products=moments.products - self.with_data.T @ of_basis,
            energy=moments.energy - np.sum(self.with_data * of_data, axis=0),
        )

    def amplitudes(self, state: FitState) -> Array:
        """Coefficients of the columns that are fitted together with this ring-down, (z, channels)."""
        values = np.zeros((self.with_data.shape[1], self.with_basis.shape[1]))
        values[:, :2], values[:, -1] = state.observation.gains(state.dynamics.w), state.offsets
        return np.asarray(np.linalg.solve(self.with_themselves, self.with_data - self.with_basis @ values.T))


def nuisance_moments(
    record: RingDownRecord, model: RingDownModel, state: FitState, nuisance: Nuisance
) -> NuisanceMoments:
    """Pass over the samples with the directly integrated motion, a stretch at a time.

    Raises:
        LostTrajectoryError: the state does not oscillate.
    """
    trajectory = Trajectory(model, state.dynamics, nuisance.last * record.dt_s)
    total: Array = np.zeros(())
    for begin in range(nuisance.first, nuisance.last, LIMITS.nuisance_chunk_samples):
        end = min(begin + LIMITS.nuisance_chunk_samples, nuisance.last)
        columns = nuisance.columns(begin, end, record.dt_s)
        basis = trajectory.basis(begin, end, record.dt_s, state.observation.observable)
        rows = np.concatenate([basis, record.samples[:, begin:end], columns])
        total = total + columns @ rows.T
    b = total.shape[1] - record.channels - nuisance.size
    return NuisanceMoments(total[:, :b], total[:, b : b + record.channels], total[:, b + record.channels :])


def cleaned(record: RingDownRecord, nuisance: Nuisance, amplitudes: Array) -> RingDownRecord:
    """The record without the columns, amplitudes (size, channels)."""
    samples = record.samples.copy()
    for begin in range(nuisance.first, nuisance.last, LIMITS.nuisance_chunk_samples):
        end = min(begin + LIMITS.nuisance_chunk_samples, nuisance.last)
        samples[:, begin:end] -= amplitudes.T @ nuisance.columns(begin, end, record.dt_s)
    return replace(record, samples=samples)


def interference_notes(nuisance: Nuisance, amplitudes: Array) -> tuple[str, ...]:
    """What was removed, in words."""
    tones = nuisance.tones_hz.size
    sizes = np.hypot(amplitudes[:tones], amplitudes[tones : 2 * tones])
    notes = [
        f"steady tone at {f:.2f} Hz fitted too: amplitude {', '.join(f'{a:.3g}' for a in size)} by channel"
        for f, size in zip(nuisance.tones_hz, sizes, strict=True)
    ]
    if nuisance.degree:
        sizes = np.sqrt(np.sum(amplitudes[2 * tones :] ** 2, axis=0))
        seen = ", ".join(f"{a:.3g}" for a in sizes)
        notes.append(f"drift fitted too, a polynomial of degree {nuisance.degree}: size {seen} by channel")
    return tuple(notes)


@dataclass(frozen=True, kw_only=True)
class NuisanceFit:
    """A fit joint with nuisance columns.

    Attributes:
        problem: with the record freed from them, and the noise without their lines.
        fitted: the minimum; its matrix is that of the joint problem.
        noise: without their lines.
        notes: what was removed.
    """

    problem: FitProblem
    fitted: Minimum
    noise: NoiseModel
    notes: tuple[str, ...]


def fit_with_nuisance(
    problem: FitProblem, best: Minimum, nuisance: Nuisance, noise: NoiseModel, noise_sd: Array, frequency_hz: float
) -> NuisanceFit:
    """The joint minimum, from the minimum without the columns; noise: without their lines, noise_sd as the fit uses it.

    Raises:
        NoConvergenceError, LostTrajectoryError, numpy.linalg.LinAlgError: the steps lead nowhere.
    """
    problem = replace(problem, noise_sd=noise_sd)
    sd = harmonic_sd(problem, noise, frequency_hz)
    state = by_convention(best.state, problem.model)
    for _ in range(LIMITS.nuisance_steps):
        at = problem.evaluate(state, nuisance.last)
        cross = nuisance_moments(problem.record, problem.model, at.state, nuisance)
        normal = weighted_normal(problem.model, at.state, cross.without(at.moments), sd, at.normal)
        normal = problem.knowledge.added(normal, at.state)
        step, _ = gauss_newton_step(normal, problem.free)
        state = at.state.moved(step)
    amplitudes = cross.amplitudes(at.state)
    problem = replace(problem, record=cleaned(problem.record, nuisance, amplitudes))
    at = problem.evaluate(state, nuisance.last)
    joint = replace(problem.after(at, np.zeros(state.size)), gradient=normal.gradient, matrix=normal.matrix)
    fitted = replace(best, state=at.state, tabulated=at.state, normal=joint, moments=at.moments, left=0.0)
    return NuisanceFit(problem=problem, fitted=fitted, noise=noise, notes=interference_notes(nuisance, amplitudes))
