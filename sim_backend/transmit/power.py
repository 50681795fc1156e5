"""State of the power amplifier: enable, mute, faults, heat.  It computes in world time and knows no clock."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from sim_backend.options import AmplifierOptions

from .drive import Interval

OVER_TEMPERATURE = "over-temperature"
OVER_CURRENT = "over-current"


class PowerStage:
    """State of the amplifier, and the log of the times at which it could deliver power.

    Callers hold the world's lock.
    """

    def __init__(self, options: AmplifierOptions) -> None:
        self.options = options
        self.enabled = False
        self.muted = True
        self.fault: str | None = None
        self.clipped = False
        self._live: list[tuple[float, bool]] = [(-np.inf, False)]
        self._excess_k = 0.0
        self._excess_at_s = 0.0

    def set(self, now_s: float, *, enabled: bool | None = None, muted: bool | None = None) -> bool:
        """Change the state at `now_s`; True if that changed whether power could be delivered."""
        self.heat(now_s, 0.0)
        self.enabled = self.enabled if enabled is None else enabled
        self.muted = self.muted if muted is None else muted
        return self._log(now_s)

    def trip(self, now_s: float, cause: str) -> bool:
        """Latch a fault at `now_s`; True if that changed whether power could be delivered."""
        self.fault = cause
        return self._log(now_s)

    def reset(self, now_s: float) -> None:
        """Clear the fault at `now_s`; the amplifier is disabled and muted afterwards."""
        self.fault = None
        self.set(now_s, enabled=False, muted=True)

    def live_intervals(self, start_s: float, stop_s: float) -> tuple[Interval, ...]:
        """Intervals in which power could be delivered between two world times, counted from start_s.

        The present state is assumed to last.
        """
        edges = [start_s, *(t for t, _ in self._live if start_s < t < stop_s), stop_s]
        spans = [(a - start_s, b - start_s) for a, b in pairwise(edges) if self._live_at(a)]
        return tuple(spans)

    def excess_k(self, now_s: float) -> float:
        """Temperature of the heat sink above ambient, K."""
        tau_s = self.options.heat_capacity_j_per_k * self.options.cooling_k_per_w
        settled_k = self.options.idle_w * self.options.cooling_k_per_w if self.enabled else 0.0
        fade = float(np.exp(-max(now_s - self._excess_at_s, 0.0) / tau_s))
        return settled_k + (self._excess_k - settled_k) * fade

    def heat(self, now_s: float, delivered_j: float) -> None:
        """Account for energy delivered to the coils by `now_s`."""
        rise_k = self.options.loss_fraction * delivered_j / self.options.heat_capacity_j_per_k
        self._excess_k = self.excess_k(now_s) + rise_k
        self._excess_at_s = now_s

    def _live_at(self, time_s: float) -> bool:
        return next(live for t, live in reversed(self._live) if t <= time_s)

    def _log(self, now_s: float) -> bool:
        live = self.enabled and not self.muted and self.fault is None
        if live == self._live[-1][1]:
            return False
        self._live.append((now_s, live))
        del self._live[:-64]
        return True
