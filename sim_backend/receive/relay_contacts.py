"""Position of the relay contacts of the Tx/Rx switch at any time: dead time, bounce, stuck contacts."""

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
    """History of the contacts; immutable.

    options: of the relay; changes: (world time s, position from then on), ascending; stuck: True while the armature
    does not move; last_move_s: by target position, duration of the last move, s, from the command until the contacts
    came to rest.
    """

    options: SwitchOptions
    changes: tuple[tuple[float, SwitchPosition], ...] = field(default=((-np.inf, TRANSMIT),))
    stuck: bool = False
    last_move_s: Mapping[SwitchPosition, float] = field(default_factory=dict)

    def position(self, time_s: float) -> SwitchPosition:
        """Position of the contacts at `time_s`."""
        return next(position for t, position in reversed(self.changes) if t <= time_s)

    def heading(self) -> SwitchPosition:
        """Position of the contacts after the last command."""
        return self.changes[-1][1]

    def arrival_s(self) -> float:
        """Time at which the contacts come to rest, s."""
        return self.changes[-1][0]

    def command(self, time_s: float, target: SwitchPosition, rng: np.random.Generator) -> Contacts:
        """The history after a command at `time_s`.

        The contacts leave at once, arrive after the dead time, and bounce if the target is RECEIVE.
        """
        if self.stuck or self.heading() is target:
            return self
        kept = tuple(c for c in self.changes if c[0] < time_s) or ((-np.inf, self.position(time_s)),)
        arrival_s = time_s + self.options.dead_time_s
        changes = [(time_s, MOVING), (arrival_s, target)]
        if target is RECEIVE and self.options.bounces and self.options.bounce_s > 0:
            edges = np.sort(rng.uniform(0, self.options.bounce_s, 2 * self.options.bounces))
            changes += [(arrival_s + float(e), (MOVING, target)[i % 2]) for i, e in enumerate(edges)]
        last_move_s = {**self.last_move_s, target: changes[-1][0] - time_s}
        return replace(self, changes=(*kept, *changes), last_move_s=last_move_s)

    def with_stuck(self, stuck: bool) -> Contacts:
        """The same history with the armature stuck, or free again."""
        return replace(self, stuck=stuck)

    def with_options(self, options: SwitchOptions) -> Contacts:
        """The same history with a relay of other options from now on."""
        return replace(self, options=options)

    def shifted(self, seconds: float) -> Contacts:
        """The same history counted from another time zero."""
        return replace(self, changes=tuple((t + seconds, position) for t, position in self.changes))

    def since(self, time_s: float) -> Contacts:
        """The history from `time_s` on; earlier changes are dropped."""
        kept = tuple(c for c in self.changes if c[0] > time_s)
        return replace(self, changes=((-np.inf, self.position(time_s)), *kept))

    def spans(self, start_s: float, stop_s: float) -> list[tuple[float, float, SwitchPosition]]:
        """Intervals (start s, stop s, position) that cover start_s to stop_s without gaps."""
        edges = [start_s, *(t for t, _ in self.changes if start_s < t < stop_s), stop_s]
        return [(a, b, self.position(a)) for a, b in pairwise(edges)]
