"""A declared model together with the effects that are supposed to act as well, and how their strengths are stored."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from platform_daemon.estimation import Array, FitState, RingDownModel

from ..effects.effect import Candidate
from ..shots.linearisation import Linearisation

_STEP = 1e-4  # of the signal, for derivatives of what receivers do to it


def _rank(candidate: Candidate) -> int:
    """Torque effects, then receiver effects, then shared additive ones, then those of each shot."""
    if candidate.term is not None:
        return 0
    return 1 if candidate.change is not None else 2 if candidate.shared else 3


@dataclass(frozen=True)
class Hypothesis:
    """Effects beside a declared model.

    gone: losses of the declared model (their places among its coefficients) that are held at 0, because beside these
    effects the data want them negative.

    Common to all shots are the strengths of torque and receiver effects and the sizes of shared additive ones, in
    this order; additive effects that every shot has for itself are linear and never stored.
    """

    model: RingDownModel
    effects: tuple[Candidate, ...] = ()
    gone: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "effects", tuple(sorted(self.effects, key=_rank)))

    def plus(self, *effects: Candidate) -> Hypothesis:
        """With further effects."""
        return replace(self, effects=(*self.effects, *effects))

    def without(self, effect: Candidate) -> Hypothesis:
        """With all but one; losses are free again: they may have been negative because of it only."""
        return replace(self, effects=tuple(e for e in self.effects if e is not effect), gone=())

    @cached_property
    def torques(self) -> tuple[Candidate, ...]:
        """Effects in the equation of motion."""
        return tuple(c for c in self.effects if _rank(c) == 0)

    @cached_property
    def receivers(self) -> tuple[Candidate, ...]:
        """Effects on the receive side."""
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
        """Where the strengths of each common effect stand among all of them."""
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
        """What a shot multiplies the strengths of torque effects by, (torques,): what they are shares of, or 1."""
        values = state.dynamics.values
        return np.array([1.0 if k is None or k in self.gone else values[k] for k in self.carriers()])

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
        mask[[3 + k for k in (*self.gone, *held)]] = False
        return mask

    def extended(self, state: FitState, strengths: Array) -> FitState:
        """A state of the declared model as one of the augmented model."""
        own = state.dynamics.values[: len(self.model.coefficients)]
        values = [0.0 if k in self.gone else q for k, q in enumerate(own)]
        for c, strength, factor in zip(self.torques, strengths, self.factors(state), strict=False):
            values += [float(strength * factor), *c.hidden]
        return replace(state, dynamics=replace(state.dynamics, values=tuple(values)))

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

    def through(self, seen: Linearisation, strengths: Array) -> Linearisation:
        """A look at the data through the receiver effects: residual and Jacobian of the channels as they change them.

        Parameters that are nearly determined depend on the third digit of the Jacobian.
        """
        if not self.receivers:
            return seen
        here, jacobian = self.changes(seen, strengths), seen.jacobian.copy()
        sizes = np.linalg.norm(jacobian[: -seen.state.offsets.size].reshape(-1, here.size), axis=1)
        for k in np.flatnonzero(sizes):
            step = _STEP * float(np.linalg.norm(seen.signal) / sizes[k])
            jacobian[k] += (self.changes(seen.moved(int(k), step), strengths) - here) / step
        return replace(seen, residual=seen.residual - here, jacobian=jacobian)

    def changes(self, seen: Linearisation, strengths: Array) -> Array:
        """What the receiver effects change in the model's channels, (channels, m); products of two are left out."""
        out = np.zeros_like(seen.signal)
        for c, strength in zip(self.receivers, strengths[len(self.torques) :], strict=False):
            if c.change is not None and strength != 0.0:
                out += c.change(seen, float(strength))
        return out

    def shared_columns(self, seen: Linearisation) -> Array:
        """Columns of receiver and shared additive effects in units of the noise, (q, rows)."""
        return _columns([c for c in self.common if c.term is None], seen)

    def own_columns(self, seen: Linearisation) -> Array:
        """Columns of the additive effects of every shot in units of the noise, (q, rows)."""
        return _columns(list(self.own), seen)

    def additive_part(self, strengths: Array, shared: Array) -> Array:
        """What shared additive effects of these strengths add to the data in units of the noise, (rows,).

        shared: from shared_columns.
        """
        count = len(self.receivers)
        return np.asarray(strengths[len(self.torques) + count :] @ shared[count:])


def _columns(candidates: list[Candidate], seen: Linearisation) -> Array:
    found = [seen.started.white(c.columns(seen)) for c in candidates if c.columns is not None]
    return np.concatenate([np.empty((0, seen.whitened.size)), *found])
