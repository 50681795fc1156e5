"""Where the relay contacts of the Tx/Rx switch are at any time: dead time, bounce, being stuck."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from drivers.tx_rx_switch import SwitchPosition
from sim_backend.options import SwitchOptions

TRANSMIT, RECEIVE, MOVING = SwitchPosition.TRANSMIT, SwitchPosition.RECEIVE, SwitchPosition.MOVING


@dataclass(frozen=True)
class Contacts:
    """History of the contacts: `changes` are (world time s, position from then on), rising; immutable.

    took: to a position -> how long the last move there took, s, from the command until the contacts came to rest.
    """

    options: SwitchOptions
    changes: tuple[tuple[float, SwitchPosition], ...] = field(default=((-np.inf, TRANSMIT),))
    stuck: bool = False
    took: Mapping[SwitchPosition, float] = field(default_factory=dict)

    def position(self, time_s: float) -> SwitchPosition:
        """Where the contacts are at `time_s`."""
        return next(position for t, position in reversed(self.changes) if t <= time_s)

    def heading(self) -> SwitchPosition:
        """Where they are, or will be once they have arrived."""
        return self.changes[-1][1]

    def arrival_s(self) -> float:
        """When they come to rest."""
        return self.changes[-1][0]

    def command(self, time_s: float, target: SwitchPosition, rng: np.random.Generator) -> Contacts:
        """The history after a command at `time_s`: leave at once, arrive after the dead time, bounce on RECEIVE."""
        if self.stuck or self.heading() is target:
            return self
        kept = tuple(c for c in self.changes if c[0] < time_s) or ((-np.inf, self.position(time_s)),)
        arrival_s = time_s + self.options.dead_time_s
        changes = [(time_s, MOVING), (arrival_s, target)]
        if target is RECEIVE and self.options.bounces and self.options.bounce_s > 0:
            edges = np.sort(rng.uniform(0, self.options.bounce_s, 2 * self.options.bounces))
            changes += [(arrival_s + float(e), (MOVING, target)[i % 2]) for i, e in enumerate(edges)]
        took = {**self.took, target: changes[-1][0] - time_s}
        return replace(self, changes=(*kept, *changes), took=took)

    def jam(self, stuck: bool) -> Contacts:
        """The same history with the armature stuck, or free again."""
        return replace(self, stuck=stuck)

    def like(self, options: SwitchOptions) -> Contacts:
        """The same history with a relay of these options from now on."""
        return replace(self, options=options)

    def shifted(self, seconds: float) -> Contacts:
        """The same history counted from another time zero."""
        return replace(self, changes=tuple((t + seconds, position) for t, position in self.changes))

    def since(self, time_s: float) -> Contacts:
        """The same from a time on; nobody asks for what was before that any more."""
        kept = tuple(c for c in self.changes if c[0] > time_s)
        return replace(self, changes=((-np.inf, self.position(time_s)), *kept))

    def spans(self, start_s: float, stop_s: float) -> list[tuple[float, float, SwitchPosition]]:
        """(from, to, position) covering start_s..stop_s without gaps."""
        edges = [start_s, *(t for t, _ in self.changes if start_s < t < stop_s), stop_s]
        return [(a, b, self.position(a)) for a, b in pairwise(edges)]
