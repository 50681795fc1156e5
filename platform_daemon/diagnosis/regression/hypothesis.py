"""A declared model together with additional effects, and the storage of their strengths."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.shots.kicked_motion import Kick, KickedState
from platform_daemon.diagnosis.shots.linearisation import Linearisation
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

_LIMITS = THRESHOLDS.regression


def _rank(candidate: Candidate) -> int:
    """Torque effects, then receiver effects and kicks, then shared additive ones, then those of each shot."""
    if candidate.term is not None:
        return 0
    if not candidate.additive:
        return 1
    return 2 if candidate.shared else 3


@dataclass(frozen=True)
class Hypothesis:
    """A declared model with additional effects.

    held_at_zero: indices of the declared model's losses that are fixed to 0, because with these effects the best fit
    would have them negative.

    Common to all shots are the strengths of torque and receiver effects and the sizes of shared additive ones, in
    this order; additive effects that every shot has for itself are linear and never stored.
    """

    model: RingDownModel
    effects: tuple[Candidate, ...] = ()
    held_at_zero: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "effects", tuple(sorted(self.effects, key=_rank)))

    def plus(self, *effects: Candidate) -> Hypothesis:
        """With further effects."""
        return replace(self, effects=(*self.effects, *effects))

    def without(self, effect: Candidate) -> Hypothesis:
        """With all effects but one; losses are free again, because that effect may have made them negative."""
        return replace(self, effects=tuple(e for e in self.effects if e is not effect), held_at_zero=())

    @cached_property
    def torques(self) -> tuple[Candidate, ...]:
        """Effects in the equation of motion."""
        return tuple(c for c in self.effects if _rank(c) == 0)

    @cached_property
    def receivers(self) -> tuple[Candidate, ...]:
        """Effects on the receive side, and kicks, which act on what the model gives as those do."""
        return tuple(c for c in self.effects if _rank(c) == 1)

    @cached_property
    def common(self) -> tuple[Candidate, ...]:
        """Effects with strengths common to all shots."""
        return tuple(c for c in self.effects if _rank(c) < 3)

    @cached_property
    def own(self) -> tuple[Candidate, ...]:
        """Additive effects of every shot."""
        return tuple(c for c in self.effects if _rank(c) == 3)

    @cached_property
    def augmented(self) -> RingDownModel:
        """The declared model with the torque terms of the effects."""
        terms = [c.term for c in self.torques if c.term is not None]
        if not terms:
            return self.model
        return self.model.with_terms("+".join([self.model.name, *(t.name for t in terms)]), *terms)

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        """Slices of the common strengths, one per effect."""
        ends = np.cumsum([0, *(c.size for c in self.common)])
        return tuple(slice(int(a), int(b)) for a, b in itertools.pairwise(ends))

    @property
    def size(self) -> int:
        """Number of common strengths."""
        return sum(c.size for c in self.common)

    def strength_places(self) -> list[int]:
        """Parameters of the augmented FitState that are strengths, one per torque effect."""
        places, place = [], 3 + len(self.model.coefficients)
        for c in self.torques:
            assert c.term is not None
            places.append(place)
            place += len(c.term.coefficients)
        return places

    def carriers(self) -> list[int | None]:
        """Places among the declared coefficients that the strengths of torque effects are shares of, if any."""
        names = [c.name for c in self.model.coefficients]
        return [names.index(c.of) if c.of else None for c in self.torques]

    def factors(self, state: FitState) -> Array:
        """Factors of the torque effects' strengths in a shot, (torques,): the coefficient they are shares of, or 1."""
        values = state.dynamics.values
        return np.array([1.0 if k is None or k in self.held_at_zero else values[k] for k in self.carriers()])

    def declared(self, size: int) -> np.ndarray:
        """Parameters of an augmented FitState of this size that each shot has for itself, bool (size,)."""
        mask = np.ones(size, dtype=bool)
        first = 3 + len(self.model.coefficients)
        mask[first : 3 + len(self.augmented.coefficients)] = False
        return mask

    def free(self, size: int) -> np.ndarray:
        """Parameters of a declared FitState of this size that are fitted, bool (size,).

        All but the losses held at 0 and the coefficients that the model itself holds: those of an adopted effect.
        """
        mask = np.ones(size, dtype=bool)
        known = self.model.parameters
        held = [k for k, c in enumerate(self.model.coefficients) if known[c.name].fixed is not None]
        mask[[3 + k for k in (*self.held_at_zero, *held)]] = False
        return mask

    def extended(self, state: FitState, strengths: Array) -> FitState:
        """A state of the declared model as one of the augmented model, with the kicks that it had or that there are.

        Raises LostTrajectoryError as `_kicks` does.
        """
        own = state.dynamics.values[: len(self.model.coefficients)]
        values = [0.0 if k in self.held_at_zero else q for k, q in enumerate(own)]
        for c, strength, factor in zip(self.torques, strengths, self.factors(state), strict=False):
            values += [float(strength * factor), *c.hidden]
        dynamics, kicks = replace(state.dynamics, values=tuple(values)), self._kicks(state, strengths)
        if kicks:
            return KickedState(dynamics, state.observation, state.offsets, kicks)
        return replace(state, dynamics=dynamics)

    def _kicks(self, state: FitState, strengths: Array) -> tuple[Kick, ...]:
        """In the order of their times; small ones beside torques that depend on time count to first order.

        Raises LostTrajectoryError for a large one beside such torques.
        """
        rest = strengths[len(self.torques) :]
        pairs = zip(self.receivers, rest[: len(self.receivers)], strict=True)
        found = [Kick(c.kick_at_s, float(s)) for c, s in pairs if c.kick_at_s is not None and s != 0.0]
        if not self.augmented.time_dependent:
            return tuple(sorted(found, key=lambda kick: kick.time_s))
        d = state.dynamics
        if any(abs(kick.speed_rad_per_s) > _LIMITS.first_order_kick * abs(d.amplitude) * d.w for kick in found):
            raise LostTrajectoryError("a kick beside torques that depend on time is too large for its first order")
        return ()

    def reduced(self, state: FitState) -> FitState:
        """A state of the augmented model as one of the declared model."""
        values = state.dynamics.values[: len(self.model.coefficients)]
        return replace(state, dynamics=replace(state.dynamics, values=values))

    def torque_rows(self, state: FitState, strengths: Array, base: Array) -> tuple[Array, Array]:
        """From rows for the parameters of the augmented state (p, n) to those of the declared ones and of strengths."""
        places, own = self.strength_places(), base[self.declared(base.shape[0])]
        for place, carrier, strength in zip(places, self.carriers(), strengths, strict=False):
            if carrier is not None:
                own[3 + carrier] += strength * base[place]
        return own, np.asarray(self.factors(state)[:, None] * base[places])

    def through(self, linearisation: Linearisation, strengths: Array) -> Linearisation:
        """The linearisation with the receiver effects applied, and a torque's course counted as noise."""
        return self.received(linearisation, strengths).with_course_as_noise()

    def received(self, linearisation: Linearisation, strengths: Array) -> Linearisation:
        """The linearisation with the receiver effects applied to residual and Jacobian.

        Parameters that are nearly determined depend on the third digit of the Jacobian.
        """
        if not self.receivers:
            return linearisation
        here = self.changes(linearisation, strengths)
        if all(c.change is None for c in self.receivers):  # kicks alone, whose answer moves little with the parameters
            return replace(linearisation, residual=linearisation.residual - here)
        jacobian = linearisation.jacobian.copy()
        sizes = np.linalg.norm(jacobian[: -linearisation.state.offsets.size].reshape(-1, here.size), axis=1)
        for k in np.flatnonzero(sizes):
            step = _LIMITS.receiver_step * float(np.linalg.norm(linearisation.signal) / sizes[k])
            jacobian[k] += (self.changes(linearisation.moved(int(k), step), strengths) - here) / step
        return replace(linearisation, residual=linearisation.residual - here, jacobian=jacobian)

    def changes(self, linearisation: Linearisation, strengths: Array) -> Array:
        """Change of the model's channels by the receiver effects, (channels, m); interactions of two are neglected.

        Where torques depend on time, kicks are among them, to first order; elsewhere `extended` has them.
        """
        out = np.zeros_like(linearisation.signal)
        for c, strength in zip(self.receivers, strengths[len(self.torques) :], strict=False):
            if c.change is not None and strength != 0.0:
                out += c.change(linearisation, float(strength))
            elif c.columns is not None and c.kick_at_s is not None and self.augmented.time_dependent:
                out += strength * c.columns(linearisation)[0]
        return out

    def shared_columns(self, linearisation: Linearisation) -> Array:
        """Columns of receiver and shared additive effects in units of the noise, (q, rows)."""
        return _columns([c for c in self.common if c.term is None], linearisation)

    def own_columns(self, linearisation: Linearisation) -> Array:
        """Columns of the additive effects of every shot in units of the noise, (q, rows)."""
        return _columns(list(self.own), linearisation)

    def additive_part(self, strengths: Array, shared: Array) -> Array:
        """What shared additive effects of these strengths add to the data in units of the noise, (rows,).

        shared: from shared_columns.
        """
        count = len(self.receivers)
        return np.asarray(strengths[len(self.torques) + count :] @ shared[count:])


def _columns(candidates: list[Candidate], linearisation: Linearisation) -> Array:
    found = [linearisation.white(c.columns(linearisation)) for c in candidates if c.columns is not None]
    return np.concatenate([np.empty((0, linearisation.whitened.size)), *found])
