"""Simulates the running shot, or the last one.

A shot is computed when a result is first needed, outside the world's lock.  An open-ended shot is a sequence of legs:
the sample source gives the timeline of each leg, and an observer stores the effects of shots on the world.
"""

from __future__ import annotations

import threading
from dataclasses import replace
from typing import TYPE_CHECKING, Protocol

import numpy as np

from drivers.errors import DeviceFault
from drivers.timeline import Timeline
from sim_backend.receive.shot_setup import ShotSetup
from sim_backend.transmit.power import PowerStage

from .clock import SimulatedClock

if TYPE_CHECKING:
    from .shot import ShotResult


class SampleSource(Protocol):
    """Source of the timelines of an open-ended shot, and receiver of its results; samples count from the trigger.

    delay_s: of the record, see `ShotSetup`.  All methods are called with the world's lock held.
    """

    delay_s: float

    def timeline(self, first_sample: int, samples: int | None = None) -> Timeline:
        """The timeline from a sample on, as far as known now; samples: its length, None: the source chooses it."""

    def leg_ended(self, first_sample: int, result: ShotResult) -> None:
        """Take over the result of a leg that has ended; first_sample: its first sample."""


class Observer(Protocol):
    """Stores the effects of shots on the world.  All methods are called with the world's lock held."""

    def became_visible(self, setup: ShotSetup, result: ShotResult, since_s: float, until_s: float) -> None:
        """Latch the events between two times, s after the trigger."""

    def account_power(self, setup: ShotSetup, result: ShotResult) -> None:
        """Record heat and power of a shot, or of a leg, that has ended."""

    def shot_ended(self, setup: ShotSetup, result: ShotResult) -> None:
        """Take over the state at the end of the shot as the state of the world."""


class ShotSimulator:
    """Simulates shots one after the other.

    Any thread may call any method; only a thread that holds the world's lock may read `setup` and `running` or call
    `begin`, `amplifier_changed` and `finish_if_over`.
    """

    def __init__(self, clock: SimulatedClock, lock: threading.RLock, power: PowerStage, observer: Observer) -> None:
        self._clock = clock
        self._lock = lock
        self._power = power
        self._observer = observer
        self.setup: ShotSetup | None = None
        self.running = False
        self._source: SampleSource | None = None
        self._start_s = 0.0
        self._leg_first = 0
        self._first_leg: tuple[ShotSetup, ShotResult] | None = None
        self._published_s = -np.inf
        self._compute = threading.Lock()
        self._cached: tuple[ShotSetup, ShotResult] | None = None

    def begin(self, setup: ShotSetup, source: SampleSource | None) -> None:
        """Start a shot; with a source it is open-ended: `setup` is the first leg, the source gives the next ones."""
        self.setup = setup.with_trip()
        self.running = True
        self._published_s = -np.inf
        self._source = source
        self._start_s = setup.start_s
        self._leg_first = 0
        self._first_leg = None

    def result(self) -> tuple[ShotSetup, ShotResult]:
        """Set-up and result of the last shot, or of the running leg.  Raises DeviceFault if there is none.

        The caller may hold the world's lock; to avoid a deadlock, no thread acquires that lock while it holds
        `_compute`.
        """
        with self._compute:
            while True:
                setup, cached = self.setup, self._cached
                if setup is None:
                    raise DeviceFault("no shot has been made yet", where="simulated world", remedy="trigger one")
                if cached is not None and cached[0] is setup:
                    return cached
                self._cached = (setup, _simulated(setup))

    def leg(self) -> tuple[int, ShotResult]:
        """Number of the first sample of the present leg of an open-ended shot, and the result of that leg."""
        while True:
            setup, result = self.result()
            with self._lock:
                if setup is self.setup:
                    return self._leg_first, result

    def leg_first(self) -> int:
        """Number of the first sample of the present leg."""
        with self._lock:
            return self._leg_first

    def extend(self, stop_sample: int) -> None:
        """Simulate an open-ended shot up to a sample, if the shot is still running."""
        while True:
            with self._lock:
                setup = self.setup
                if not self.running or self._source is None or setup is None or self._leg_stop() >= stop_sample:
                    return
            _, result = self.result()
            with self._lock:
                if self.running and self.setup is setup:
                    self._next_leg(setup, result)

    def replan(self) -> None:
        """Read the timeline of an open-ended shot from its source again, because it has changed.

        The length of the present leg may change only if the leg has not been computed yet.
        """
        with self._lock:
            if self.running and self._source is not None and self.setup is not None:
                computed = self._cached is not None and self._cached[0] is self.setup
                samples = self.setup.timeline.total_samples if computed else None
                timeline = self._source.timeline(self._leg_first, samples)
                if timeline != self.setup.timeline:
                    end_s = self.setup.start_s + timeline.duration_s
                    live = self._power.live_intervals(self.setup.start_s, end_s)
                    changed = replace(self.setup, timeline=timeline, stop_s=timeline.duration_s, live=live)
                    self.setup = changed.with_trip()

    def stop(self) -> None:
        """Set all outputs to zero and all lines low now: truncate the running shot, if there is one."""
        self.catch_up()
        with self._lock:
            if self.setup is None or not self.running:
                return
            elapsed = self._clock.monotonic_s() - self.setup.start_s
            if self._source is not None:
                self._stop_open_ended(elapsed)
                return
            if elapsed < self.setup.stop_s:
                self.setup = replace(self.setup, stop_s=max(elapsed, 1e-9))
            self._end_shot(self.setup)

    def refresh(self) -> None:
        """Publish all events up to now to the observer."""
        self.catch_up()
        with self._lock:
            running = self.running
        if running:
            setup, result = self.result()
            with self._lock:
                if setup is self.setup:
                    self._publish(setup, result, self._clock.monotonic_s() - setup.start_s)
                self.finish_if_over()

    def first(self) -> tuple[ShotSetup, ShotResult] | None:
        """Set-up and result of the last shot, or of its first leg if it is open-ended; None before the first shot."""
        with self._lock:
            if self.setup is None:
                return None
        return self._first_leg or self.result()

    def amplifier_changed(self) -> None:
        """Take a change of the amplifier during the shot into account for the rest of the shot."""
        assert self.setup is not None
        start_s = self.setup.start_s
        stop_s = start_s + self.setup.timeline.duration_s
        changed = replace(self.setup, live=self._power.live_intervals(start_s, stop_s)).with_trip()
        if changed.powered() != self.setup.powered():
            self.setup = changed

    def finish_if_over(self) -> None:
        """End the running shot if its time is over."""
        setup = self.setup
        if setup is None or not self.running or self._source is not None:
            return
        if self._clock.monotonic_s() >= setup.start_s + setup.stop_s:
            self._end_shot(setup)

    def catch_up(self) -> None:
        """Simulate an open-ended shot up to now."""
        with self._lock:
            running = self.running and self._source is not None and self.setup is not None
            rate_hz = self.setup.timeline.clock.rate_hz if self.setup is not None else 0.0
            now = int((self._clock.monotonic_s() - self._start_s) * rate_hz) + 1
        if running:
            self.extend(now)

    def _leg_stop(self) -> int:
        assert self.setup is not None
        return self._leg_first + self.setup.timeline.total_samples

    def _next_leg(self, setup: ShotSetup, result: ShotResult) -> None:
        """Continue an open-ended shot from the end of a leg."""
        from .shot import next_leg  # here: see `_simulated`

        assert self._source is not None
        self._publish(setup, result, setup.stop_s)
        self._source.leg_ended(self._leg_first, result)
        end_s = setup.start_s + setup.stop_s
        self._observer.account_power(setup, result)
        self._leg_first = self._leg_stop()
        self._first_leg = self._first_leg or (setup, result)
        timeline = self._source.timeline(self._leg_first)
        live = self._power.live_intervals(end_s, end_s + timeline.duration_s)
        self.setup = next_leg(setup, result, timeline, live)
        self._published_s = -np.inf

    def _stop_open_ended(self, elapsed_s: float) -> None:
        """End the running leg of an open-ended shot."""
        assert self.setup is not None
        assert self._source is not None
        stop_s = min(max(elapsed_s, 1e-9), self.setup.stop_s)
        from .shot import truncated  # here: see `_simulated`

        if self._cached is not None and self._cached[0] is self.setup:
            self._cached = truncated(*self._cached, stop_s)
        else:
            self._cached = self._result_of(replace(self.setup, stop_s=stop_s))
        self.setup, result = self._cached
        self._source.leg_ended(self._leg_first, result)
        self._end_shot(self.setup)

    def _publish(self, setup: ShotSetup, result: ShotResult, elapsed_s: float) -> None:
        """Report the events up to `elapsed_s` after the trigger to the observer, each once."""
        self._observer.became_visible(setup, result, self._published_s, elapsed_s)
        self._published_s = max(self._published_s, elapsed_s)

    def _end_shot(self, setup: ShotSetup) -> None:
        self.running = False
        setup, result = self._result_of(setup)
        self._observer.shot_ended(setup, result)
        self._observer.account_power(setup, result)
        self._publish(setup, result, setup.stop_s)

    def _result_of(self, setup: ShotSetup) -> tuple[ShotSetup, ShotResult]:
        if self._cached is None or self._cached[0] is not setup:
            self._cached = (setup, _simulated(setup))
        return self._cached


def _simulated(setup: ShotSetup) -> ShotResult:
    """The result of a shot.  It is simulated by kernels, so the compiler is loaded here and not with the world."""
    from .shot import simulate

    return simulate(setup)
