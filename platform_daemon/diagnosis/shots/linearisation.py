"""Linearisation of one shot at a state: residual, Jacobian and time derivatives of the model."""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import block_diag

from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.gauss_newton import FitState, coefficient_jacobian
from platform_daemon.estimation.moments.workspace import Workspace
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.numerics.finite_differences import REACH, derivative
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.basis_functions import STATE
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError, Trajectory

from .kicked_motion import KickedState, kicked_basis, kicks_of
from .shot import PreparedShot
from .torque_course import ProcessNoise, TorqueCourse, course_of

_LIMITS = THRESHOLDS.shots
_KEEPING = threading.Lock()
_BY_THETA = slice(2, 4)  # rows of a basis


@dataclass(frozen=True)
class Linearisation:
    """A shot at a state of a model, on its grids, all pieces side by side.

    Attributes:
        prepared: the shot with its grids.
        state: where the model is linearised.
        odd, even: (channels, m) parts of the model's channels from f1 and f2, near odd and even multiples of the
            fundamental, without offsets.
        slopes: (2, channels, m) time derivatives of these two parts.
        residual: (channels, m) data minus model.
        jacobian: (p, channels, m) d model / d parameter, in the order of FitState.moved; even_jacobian: its part from
            f2.
        free_motion: (2, 2, m) of an angle: two solutions of the linearised equation of motion, angle and velocity /w;
            (2, 2, 0) of what else is recorded.
        course_rows: places among the parameters of the coefficients of a torque's course, and of its knots; None:
            they are none.
        process: what such a course adds to the noise.
    """

    prepared: PreparedShot
    state: FitState
    odd: Array
    even: Array
    slopes: Array
    residual: Array
    jacobian: Array
    even_jacobian: Array
    free_motion: Array
    course_rows: tuple[slice, slice] | None = None
    process: ProcessNoise | None = None

    @classmethod
    def of_basis(cls, prepared: PreparedShot, state: FitState, basis: Array, steepness: Array) -> Linearisation:
        """The model's channels only, from `basis_with_slopes`: no residual, no Jacobian."""
        d, gains = state.dynamics, state.observation.gains(state.dynamics.w)
        odd, even = gains[:, :1] * basis[0], gains[:, 1:] * basis[1]
        slopes = d.w * np.stack([gains[:, :1] * steepness[0], gains[:, 1:] * steepness[1]])
        nothing = np.zeros((0, *odd.shape))
        # Derivatives by phase and by amplitude.
        free = np.stack([basis[2:4], basis[6:8]]) if state.observation.observable == STATE else np.zeros((2, 2, 0))
        return cls(prepared, state, odd, even, slopes, nothing, nothing, nothing, free)

    def moved(self, parameter: int, step: float) -> Linearisation:
        """The model's channels after a small step of a parameter, to first order; not of an offset."""
        even = step * self.even_jacobian[parameter]
        odd = step * self.jacobian[parameter] - even
        slopes = np.stack([self._derived(part) for part in (odd, even)])
        return replace(self, odd=self.odd + odd, even=self.even + even, slopes=self.slopes + slopes)

    def without_jacobian(self) -> Linearisation:
        """A copy without the Jacobian, which takes ten times the memory of everything else."""
        nothing = np.zeros((0, *self.odd.shape))
        kept = replace(self, jacobian=nothing, even_jacobian=nothing)
        kept.__dict__["whitened"] = self.whitened
        return kept

    def without_process(self) -> Linearisation:
        """A copy without the noise of a course, of which only `whitened` still knows."""
        kept = replace(self, process=None)
        kept.__dict__["whitened"] = self.whitened
        return kept

    @property
    def time_s(self) -> Array:
        """(m,)."""
        return self.prepared.time_s

    @cached_property
    def signal(self) -> Array:
        """(channels, m) the model's channels, without offsets."""
        return np.asarray(self.odd + self.even)

    @cached_property
    def slope(self) -> Array:
        """(channels, m) its time derivative."""
        return np.asarray(self.slopes.sum(axis=0))

    @cached_property
    def _derivatives(self) -> list[Array]:
        return [np.asarray(self.prepared.shot.to_volts @ self.slope)]

    def derivative_v(self, order: int) -> Array:
        """(channels, m) time derivative of this order at the digitiser, found once."""
        found = self._derivatives
        while len(found) < order:
            found.append(self._derived(found[-1]))
        return found[order - 1]

    def _derived(self, samples: Array) -> Array:
        """Time derivative (channels, m), piece by piece."""
        rate, grids = self.prepared.shot.rate_hz, self.prepared.grids
        parts = []
        for k, (g, where) in enumerate(zip(grids, self.prepared.white.slices, strict=True)):
            before, after = self._neighbours(samples, k)
            wide = derivative(np.concatenate([before, samples[:, where], after], axis=1), rate / g.factor)
            parts.append(wide[:, before.shape[1] : wide.shape[1] - after.shape[1]])
        return np.concatenate(parts, axis=1)

    def _neighbours(self, samples: Array, k: int) -> tuple[Array, Array]:
        """Samples before and after a decimated piece at its own step, from its neighbours that have every sample.

        From a decimated piece alone, derivatives at its ends would be poor.
        """
        grids, slices = self.prepared.grids, self.prepared.white.slices
        factor, nothing = grids[k].factor, samples[:, :0]
        if factor == 1 or len(grids) == 1:
            return nothing, nothing
        before, after = samples[:, slices[k - 1]], samples[:, slices[k + 1]]
        return before[:, ::-1][:, factor - 1 :: factor][:, :REACH][:, ::-1], after[:, ::factor][:, :REACH]

    def with_course_as_noise(self) -> Linearisation:
        """The same with the answer to the course of a torque, where there is one, as noise instead of parameters.

        To first order around the likeliest course x0 the data are y = f(theta, x0) + K (x - x0) + noise, where x is
        random with covariance L L^T.  K x0 is added to the residual, and K x counted as noise: what is fitted or tested
        with it are generalised least squares with the covariance 1 + K L L^T K^T in units of the noise, which know how
        much of everything the fluctuation may be, and have errors that say so.  What pumps the amplitude between the
        knots is noise likewise.
        """
        course = course_of(self.state)
        if course is None or self.course_rows is None:
            return self
        every, knots = self.course_rows
        answers = self.jacobian[knots]
        pumped, root = self.pumped_amplitude(course)
        return replace(
            self,
            residual=self.residual + np.tensordot(course.values, answers, 1),
            jacobian=np.delete(self.jacobian, every, axis=0),
            even_jacobian=np.delete(self.even_jacobian, every, axis=0),
            course_rows=None,
            process=ProcessNoise.of(
                np.concatenate([self.prepared.white(answers), pumped]), block_diag(course.root, root)
            ),
        )

    def pumped_amplitude(self, course: TorqueCourse) -> tuple[Array, Array]:
        """What the amplitude's walk adds, in units of the noise (k, channels m), and the root of its covariance.

        To first order f1 goes with the amplitude and f2 with its square; the phase that follows is the course's.
        """
        windows, root = course.pumped_amplitude(self.time_s)
        if not len(windows):
            return np.zeros((0, self.odd.size)), root
        return self.prepared.white(windows[:, None, :] * (self.odd + 2.0 * self.even)), root

    def white(self, columns: Array) -> Array:
        """Columns (..., channels, m) in units of the noise, (..., channels m)."""
        rows = self.prepared.white(columns)
        return rows if self.process is None else self.process.taken_out(rows)

    @cached_property
    def whitened(self) -> Array:
        """Residual in units of its noise, flat (channels m,)."""
        return self.white(self.residual)

    @cached_property
    def base(self) -> Array:
        """Jacobian in units of the noise, (p, channels m)."""
        return self.white(self.jacobian)

    @cached_property
    def volts(self) -> Array:
        """The model's channels at the digitiser, (channels, m)."""
        return np.asarray(self.prepared.shot.to_volts @ self.signal)


def linearise_signal(
    prepared: PreparedShot, model: RingDownModel, state: FitState, *, frozen_course: bool = False
) -> Linearisation:
    """Evaluate a state, with the course of a torque where the shot has one.

    frozen_course: without derivatives by its knots, which take most of the time.  The derivative by w then holds the
    course's coefficients in units of w, and is right for everything but the course.

    Raises:
        LostTrajectoryError: the state does not oscillate, or has left what the shot can be.
    """
    _check(prepared, state)
    seen, traced, course = state, model, course_of(state)
    if course is not None:
        seen, traced = course.extended(state), course.model(model, frozen=frozen_course)
    basis, steepness = basis_with_slopes(prepared, traced, seen)
    if not np.abs(basis).max() < _LIMITS.largest_sensitivity:
        raise LostTrajectoryError("the motion answers without bounds to its parameters")
    found = Linearisation.of_basis(prepared, state, basis, steepness)
    residual = prepared.data - found.signal - state.offsets[:, None]
    by_parameter = coefficient_jacobian(model, state) if frozen_course else coefficient_jacobian(traced, seen)
    even = np.tensordot(by_parameter[..., 1::2], basis[1::2], 1)
    rows = None if course is None or frozen_course else course.places(model)
    return replace(
        found, residual=residual, jacobian=np.tensordot(by_parameter, basis, 1), even_jacobian=even, course_rows=rows
    )


def _check(prepared: PreparedShot, state: FitState) -> None:
    """Refuse a trial step that leads far away, where tables and trajectories would be very large."""
    here, start = state.dynamics, prepared.state.dynamics
    if not (_LIMITS.stray_ratio > here.w / start.w > 1.0 / _LIMITS.stray_ratio and abs(here.amplitude) < math.pi):
        raise LostTrajectoryError("the motion is no longer that of the shot")


def basis_at(prepared: PreparedShot, model: RingDownModel, state: FitState, observable: int | None = None) -> Array:
    """The kernel's basis at the instants, (b, m), read-only and cached: several callers evaluate the same state.

    observable: None for the recorded one.
    """
    return basis_with_slopes(prepared, model, state, observable)[0]


def basis_with_slopes(
    prepared: PreparedShot, model: RingDownModel, state: FitState, observable: int | None = None
) -> tuple[Array, Array]:
    """The same, and the time derivatives (2, m) of its first two rows in units of w."""
    observable = state.observation.observable if observable is None else observable
    places = tuple((g.first, g.last, g.factor) for g in prepared.grids)
    key = (model.terms, state.dynamics, kicks_of(state), observable, places)
    found = prepared.bases.get(key)
    if found is None:
        found = _basis(prepared, model, state, observable)
        if len(model.coefficients) > _LIMITS.kept_coefficients:
            return _split(found, state)
        found.flags.writeable = False
        keep(prepared.bases, key, found)
    return _split(found, state)


def keep(bases: dict[tuple[object, ...], Array], key: tuple[object, ...], found: Array) -> None:
    """Add to a cache of bases in the place of the oldest one; fits of many threads share it."""
    with _KEEPING:
        while len(bases) >= _LIMITS.kept_bases:
            del bases[next(iter(bases))]
        bases[key] = found


def _basis(prepared: PreparedShot, model: RingDownModel, state: FitState, observable: int) -> Array:
    """The basis; after kicks the time derivatives of its first two rows are no longer among the others, and last."""
    d, rate = state.dynamics, prepared.shot.rate_hz
    # Torques that depend on time are integrated once; the others have tables.
    places = [(g.first, g.last, g.factor / rate) for g in prepared.grids]
    if isinstance(state, KickedState):
        pieces = [np.concatenate(kicked_basis(model, state, *place, observable)) for place in places]
        return np.concatenate(pieces, axis=1)
    if model.time_dependent:
        trajectory = Trajectory(model, d, max(last * dt_s for _, last, dt_s in places))
        return np.concatenate([trajectory.basis(*place, observable) for place in places], axis=1)
    workspace = Workspace(model)
    return np.concatenate([workspace.basis(d, *place, observable) for place in places], axis=1)


def _split(found: Array, state: FitState) -> tuple[Array, Array]:
    """The basis and the time derivatives, which are those by theta where nothing was kicked."""
    return (found[:-2], found[-2:]) if isinstance(state, KickedState) else (found, found[_BY_THETA])
