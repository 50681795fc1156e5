"""The power amplifier's inner life: enable, mute, faults, heat.  Pure bookkeeping in world time."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from sim_backend.options import AmplifierOptions

from .drive import Interval

OVER_TEMPERATURE = "over-temperature"
OVER_CURRENT = "over-current"


class PowerStage:
    """State of the amplifier and the log of when it could put out power.  The world's lock protects it."""

    def __init__(self, options: AmplifierOptions) -> None:
        self.options = options
        self.enabled = False
        self.muted = True
        self.fault: str | None = None
        self.clipped = False
        self._live: list[tuple[float, bool]] = [(-np.inf, False)]
        self._excess_k, self._excess_at_s = 0.0, 0.0

    def set(self, now_s: float, *, enabled: bool | None = None, muted: bool | None = None) -> bool:
        """Change state at `now_s`; True if that changed whether power could come out."""
        self.heat(now_s, 0.0)
        self.enabled = self.enabled if enabled is None else enabled
        self.muted = self.muted if muted is None else muted
        return self._log(now_s)

    def trip(self, now_s: float, cause: str) -> bool:
        """Latch a fault at `now_s`."""
        self.fault = cause
        return self._log(now_s)

    def reset(self, now_s: float) -> None:
        """Clear the fault; disabled and muted afterwards."""
        self.fault = None
        self.set(now_s, enabled=False, muted=True)

    def live_intervals(self, start_s: float, stop_s: float) -> tuple[Interval, ...]:
        """When it could put out power within a stretch, counted from start_s; the present state is taken to last."""
        edges = [start_s, *(t for t, _ in self._live if start_s < t < stop_s), stop_s]
        spans = [(a - start_s, b - start_s) for a, b in pairwise(edges) if self._live_at(a)]
        return tuple(spans)

    def excess_k(self, now_s: float) -> float:
        """Heat sink above ambient, K."""
        tau_s = self.options.heat_capacity_j_per_k * self.options.cooling_k_per_w
        settled_k = self.options.idle_w * self.options.cooling_k_per_w if self.enabled else 0.0
        fade = float(np.exp(-max(now_s - self._excess_at_s, 0.0) / tau_s))
        return settled_k + (self._excess_k - settled_k) * fade

    def heat(self, now_s: float, delivered_j: float) -> None:
        """Account for energy delivered to the coils by `now_s`."""
        rise_k = self.options.loss_fraction * delivered_j / self.options.heat_capacity_j_per_k
        self._excess_k, self._excess_at_s = self.excess_k(now_s) + rise_k, now_s

    def _live_at(self, time_s: float) -> bool:
        return next(live for t, live in reversed(self._live) if t <= time_s)

    def _log(self, now_s: float) -> bool:
        live = self.enabled and not self.muted and self.fault is None
        if live == self._live[-1][1]:
            return False
        self._live.append((now_s, live))
        del self._live[:-64]
        return True
