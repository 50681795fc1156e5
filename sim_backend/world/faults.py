"""Deliberate faults.

overwritten, corrupted, lost_steps   the card flags one chunk in the middle of the shot
dropped_samples                      the card loses DROPPED samples in the middle: first_sample jumps
card_timeout                         from the middle on the card delivers no samples
amplifier_trip                       the amplifier trips in the middle of the transmit gate
relay_bounce                         the contacts bounce ten times as long and as often
switch_stuck                         from this shot on the contacts do not move, until a repair
switch_welded                        in this shot the contacts weld to the receiver, until a repair
lna_overload                         a burst of interference overloads the LNA in the middle of the shot
adc_clip                             the converter is driven beyond its range in the middle of the shot
"""

from __future__ import annotations

import threading

from drivers.errors import ConfigError
from sim_backend.options import FaultOptions

KINDS = tuple(FaultOptions.model_fields)
FLAGS = ("overwritten", "corrupted", "lost_steps")
DROPPED = 64


class FaultPlan:
    """Which fault occurs at which shot.  Any thread may call any method."""

    def __init__(self, options: FaultOptions) -> None:
        self._lock = threading.Lock()
        self._plan = {kind: set(getattr(options, kind)) for kind in KINDS}

    def inject(self, kind: str, shot: int) -> None:
        """Let the fault `kind` occur at shot number `shot`.  Raises ConfigError for an unknown kind."""
        if kind not in KINDS:
            raise ConfigError(f"no fault is called {kind!r}", remedy=f"use one of {', '.join(KINDS)}")
        with self._lock:
            self._plan[kind].add(shot)

    def clear(self) -> None:
        """Remove all faults from the plan."""
        with self._lock:
            for shots in self._plan.values():
                shots.clear()

    def at(self, shot: int) -> frozenset[str]:
        """Faults that occur at a shot."""
        with self._lock:
            return frozenset(kind for kind, shots in self._plan.items() if shot in shots)
