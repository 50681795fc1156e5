"""Where the parameters of shots that are fitted together stand in one vector."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.rigid_rotor.rotor import RotorValues

from .parameters import Defect, FreeParameter, free_parameters
from .shot import RotorShot


@dataclass(frozen=True)
class Layout:
    """Where the free parameters of each shot stand in the common vector."""

    free: tuple[tuple[FreeParameter, ...], ...]
    places: tuple[tuple[int, ...], ...]
    size: int

    @classmethod
    def of(cls, shots: Sequence[RotorShot], defects: Iterable[Defect], held: Sequence[str]) -> Layout:
        """Of shots with these defects free, and of their free parameters none of `held`."""
        free, places, shared, size = [], [], dict[str, int](), 0
        defects = tuple(defects)
        for shot in shots:
            of_shot = tuple(p for p in free_parameters(shot.geometry, defects, shot.start) if p.name not in held)
            here = []
            for p in of_shot:
                if p.common and p.name in shared:
                    here.append(shared[p.name])
                    continue
                here.append(size)
                if p.common:
                    shared[p.name] = size
                size += 1
            free.append(of_shot)
            places.append(tuple(here))
        return cls(tuple(free), tuple(places), size)

    @property
    def most_step(self) -> Array:
        """By how much one step may move each parameter, (size,)."""
        most = np.full(self.size, np.inf)
        for free, places in zip(self.free, self.places, strict=True):
            for p, k in zip(free, places, strict=True):
                most[k] = p.most_step
        return most

    def place(self, name: str) -> int:
        """Of a common parameter in the vector."""
        return next(k for p, k in zip(self.free[0], self.places[0], strict=True) if p.name == name)

    def moved(self, values: Sequence[RotorValues], step: Array) -> list[RotorValues]:
        """The values of each shot after a step (size,)."""
        return [
            v.with_numbers(
                {p.name: p.moved(getattr(v, p.name), float(step[k])) for p, k in zip(free, places, strict=True)}
            )
            for v, free, places in zip(values, self.free, self.places, strict=True)
        ]

    def prior(self, values: Sequence[RotorValues], first: Sequence[RotorValues]) -> tuple[Array, Array, float]:
        """Weights (size,), pull (size,) towards what was known beforehand, and its chi^2."""
        weight, off = np.zeros(self.size), np.zeros(self.size)
        for v, f, free, places in zip(values, first, self.free, self.places, strict=True):
            for p, k in zip(free, places, strict=True):
                if p.sd is not None:
                    weight[k], off[k] = p.sd**-2, p.off(getattr(v, p.name), getattr(f, p.name))
        return weight, weight * off, float(weight @ off**2)
