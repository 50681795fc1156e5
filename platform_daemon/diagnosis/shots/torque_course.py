"""The course of a torque along one shot: what it has more or less than its mean, smooth through knots."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.torques.coulomb_friction import COULOMB_FRICTION
from platform_daemon.estimation.physics.torques.hertz_friction import HERTZ_FRICTION
from platform_daemon.estimation.physics.torques.hertz_friction_under_weight import HERTZ_FRICTION_UNDER_WEIGHT
from platform_daemon.estimation.physics.torques.torque_course import (
    CONSTANT,
    FIRST_KNOT,
    HERTZ,
    torque_course_term,
)


@dataclass(frozen=True)
class ProcessNoise:
    """What a random course adds to the covariance of rows in units of the noise: U s^2 U^T.

    Attributes:
        directions: U (rows, d), orthonormal. sizes: s (d,).
        knots: (knots, d) the course that moves the rows by one of the sizes along each direction; where the amplitude
            is pumped, its steps come after the knots.
    """

    directions: Array
    sizes: Array
    knots: Array

    @classmethod
    def of(cls, answers: Array, root: Array) -> ProcessNoise:
        """Of the answers of rows to the knots of a course, (knots, rows); root: of the knots' covariance."""
        squares, vectors = np.linalg.eigh(root.T @ (answers @ answers.T) @ root)
        seen = squares > np.finfo(float).eps * squares[-1] * squares.size
        sizes, knots = np.sqrt(squares[seen]), root @ vectors[:, seen]
        return cls(answers.T @ (knots / sizes), sizes, knots)

    def taken_out(self, rows: Array) -> Array:
        """Rows (..., rows) times (1 + U s^2 U^T)^(-1/2): the covariance of what is left is 1."""
        less = 1.0 - 1.0 / np.sqrt(1.0 + self.sizes**2)
        return np.asarray(rows - ((rows @ self.directions) * less) @ self.directions.T)

    def split_at(self, kept: np.ndarray) -> SplitNoise:
        """What the noise of the kept rows says about that of the others; kept: bool (rows,)."""
        columns = self.directions * self.sizes
        known, other = columns[kept], columns[~kept]
        squares, vectors = np.linalg.eigh(known.T @ known)
        squares = np.maximum(squares, 0.0)
        return SplitNoise(
            whole=self, kept=kept, squares=squares, known=known @ vectors, left=other @ vectors / np.sqrt(1.0 + squares)
        )

    def likeliest(self, taken_out: Array) -> Array:
        """The likeliest course (knots,), and steps of the amplitude after it.

        taken_out: (rows,) from which the noise was taken out.
        """
        return np.asarray(self.knots @ (self.sizes / np.sqrt(1.0 + self.sizes**2) * (taken_out @ self.directions)))


@dataclass(frozen=True)
class SplitNoise:
    """The noise by a course in rows that are known, and what of it is left in the others when those are known.

    Attributes:
        whole: of all rows; kept: bool (rows,), the known ones.
        known: (kept, d) its orthogonal columns in the known rows, with their squares (d,).
        left: (others, d) columns of what is left in the others.
    """

    whole: ProcessNoise
    kept: np.ndarray
    squares: Array
    known: Array
    left: Array

    def first(self, rows: Array) -> Array:
        """The known ones of rows (..., rows) from which the whole noise was taken out, without their own noise."""
        z, along = self._white(rows)
        part = 1.0 - 1.0 / np.sqrt(1.0 + self.squares)
        inside = np.divide(
            part, self.squares, out=0.5 * np.ones_like(part), where=self.squares > THRESHOLDS.fluctuation.seen_square
        )
        return np.asarray(z[..., self.kept] - (along * inside) @ self.known.T)

    def rest(self, rows: Array) -> tuple[Array, Array]:
        """The others without the noise that is left in them, and in units of the white noise, less what is known."""
        z, along = self._white(rows)
        left = z[..., ~self.kept] - (along / np.sqrt(1.0 + self.squares)) @ self.left.T
        return self._of_rest.taken_out(left), left

    @cached_property
    def _of_rest(self) -> ProcessNoise:
        return ProcessNoise.of(self.left.T, np.eye(self.left.shape[1]))

    def _white(self, rows: Array) -> tuple[Array, Array]:
        """Rows in units of the white noise, with that by the course, and the known ones along their columns."""
        at = self.whole
        z = rows + ((rows @ at.directions) * (np.sqrt(1.0 + at.sizes**2) - 1.0)) @ at.directions.T
        return z, z[..., self.kept] @ self.known


_DRY = (HERTZ_FRICTION, HERTZ_FRICTION_UNDER_WEIGHT, COULOMB_FRICTION)


def dry_friction(model: RingDownModel) -> str | None:
    """Name of the coefficient of a declared model's dry friction, None if it has none."""
    return next((term.coefficients[0].name for term in model.terms if term in _DRY), None)


def friction_law(model: RingDownModel) -> float:
    """Of the angle, of a declared model's dry friction."""
    return CONSTANT if COULOMB_FRICTION in model.terms else HERTZ


@dataclass(frozen=True, kw_only=True)
class TorqueCourse:
    """What a torque of one shot has more than its mean.

    Attributes:
        step_s: time between two knots; the first one is at the first RX sample.
        values: (knots,) rad/s^2.
        law, weight: its law of the angle, see `estimation.physics.torques.torque_course`; a friction's is that of the
            declared model whatever effects there are beside it.
        root: (knots, knots) lower triangle L; L L^T is their covariance by the random process, (rad/s^2)^2.
        pumped_per_s: variance that the logarithm of the amplitude gains per second by what is faster than the knots.
    """

    step_s: float
    values: Array
    root: Array
    law: float
    weight: float
    pumped_per_s: float = 0.0

    @classmethod
    def none_of(cls, model: RingDownModel, step_s: float, root: Array, law: float) -> TorqueCourse:
        """A constant torque of a declared model, with as many knots as the root has rows."""
        known = model.parameters.get("weight_over_pull")
        weight = known.fixed if known is not None and known.fixed is not None else 0.0
        return cls(step_s=step_s, values=np.zeros(root.shape[0]), root=root, law=law, weight=weight)

    @property
    def time_s(self) -> Array:
        """Of the knots, (knots,)."""
        return np.asarray(self.step_s * np.arange(self.values.size))

    def pumped_amplitude(self, time_s: Array) -> tuple[Array, Array]:
        """How the amplitude wanders by what is faster than the knots: windows (k, m) at instants (m,), linear between
        k steps, and the root (k, k) of the covariance of its logarithm there, that of a random walk; k is 0 where
        nothing is faster."""
        if self.pumped_per_s == 0.0:
            return np.zeros((0, time_s.size)), np.zeros((0, 0))
        steps = np.linspace(0.0, float(time_s[-1]), THRESHOLDS.fluctuation.amplitude_steps + 1)
        windows = np.stack([np.interp(time_s, steps, row) for row in np.eye(steps.size)[1:]])
        step_sd = math.sqrt(self.pumped_per_s * float(steps[1]))
        return windows, step_sd * np.tri(steps.size - 1)

    def model(self, model: RingDownModel, *, frozen: bool = False) -> RingDownModel:
        """The model with this course; its coefficients come after those of the model.  frozen: no derivatives by it."""
        return model.with_terms(f"{model.name}+torque_course", torque_course_term(self.values.size, frozen=frozen))

    def extended(self, state: FitState) -> FitState:
        """A state of a model as one of this model with the course."""
        values = (*state.dynamics.values, self.step_s, self.law, self.weight, *self.values.tolist())
        return replace(state, dynamics=replace(state.dynamics, values=values))

    def places(self, model: RingDownModel) -> tuple[slice, slice]:
        """Of all its coefficients, and of its knots, in the parameters of an extended state; model: without it."""
        first = 3 + len(model.coefficients)
        last = first + FIRST_KNOT + self.values.size
        return slice(first, last), slice(first + FIRST_KNOT, last)


@dataclass(frozen=True)
class CourseState(FitState):
    """A state with the course of a torque of its shot, whose knots come last in a step."""

    course: TorqueCourse

    def moved(self, step: Array) -> CourseState:
        """The state after a step; one without the knots leaves the course as it is."""
        own, knots = FitState.moved(self, step[: self.size]), step[self.size :]
        values = self.course.values + knots if knots.size else self.course.values
        return CourseState(own.dynamics, own.observation, own.offsets, replace(self.course, values=values))


def course_of(state: FitState) -> TorqueCourse | None:
    """Of a state that has one."""
    return state.course if isinstance(state, CourseState) else None
