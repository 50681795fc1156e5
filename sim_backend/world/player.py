"""The shot that runs, or ran last: computed when somebody first needs it, outside the lock."""

from __future__ import annotations

import threading
from dataclasses import replace
from typing import Protocol

import numpy as np

from drivers.errors import DeviceFault
from drivers.timeline import Timeline
from sim_backend.receive.shot_setup import ShotSetup
from sim_backend.transmit.power import PowerStage

from .clock import SimulatedClock
from .shot import ShotResult, after, cut_short, simulate


class Feed(Protocol):
    """Where an open-ended shot gets what is played and hands over what is heard; samples are counted from the trigger.

    delay_s: of the record, see `ShotSetup`.  Called with the world's lock held.
    """

    delay_s: float

    def timeline(self, first_sample: int, samples: int | None = None) -> Timeline:
        """What will be played from a sample on, as far as is known now; None: for as long as the feed likes."""

    def leg_over(self, first_sample: int, result: ShotResult) -> None:
        """A leg is over."""


class Witness(Protocol):
    """Who keeps what shots leave behind.  Called with the lock held."""

    def seen(self, setup: ShotSetup, result: ShotResult, since_s: float, until_s: float) -> None:
        """Latch what became visible between these times after the trigger."""

    def account(self, setup: ShotSetup, result: ShotResult) -> None:
        """Heat and power of a shot, or of a leg, that is over."""

    def shot_over(self, setup: ShotSetup, result: ShotResult) -> None:
        """Make the end of the shot the state of the world."""


class Player:
    """Plays shots one after the other.  Thread-safe; `setup` and `running` are for those who hold the lock."""

    def __init__(self, clock: SimulatedClock, lock: threading.RLock, power: PowerStage, witness: Witness) -> None:
        self._clock, self._lock, self._power, self._witness = clock, lock, power, witness
        self.setup: ShotSetup | None = None
        self.running = False
        self._feed: Feed | None = None
        self._begun_s, self._leg_first = 0.0, 0
        self._first_leg: tuple[ShotSetup, ShotResult] | None = None
        self._shown_s = -np.inf
        self._compute = threading.Lock()
        self._cached: tuple[ShotSetup, ShotResult] | None = None

    def begin(self, setup: ShotSetup, feed: Feed | None) -> None:
        """Trigger; with a feed the shot is open-ended: the setup is its first leg, the feed has the next ones."""
        self.setup, self.running, self._shown_s = setup.with_trip(), True, -np.inf
        self._feed, self._begun_s, self._leg_first, self._first_leg = feed, setup.start_s, 0, None

    def result(self) -> tuple[ShotSetup, ShotResult]:
        """The last shot made or begun.  Raises DeviceFault if there is none.

        Whoever calls this may hold the world's lock, so nobody may ask for that one while holding `_compute`.
        """
        with self._compute:
            while True:
                setup, cached = self.setup, self._cached
                if setup is None:
                    raise DeviceFault("no shot has been made yet", where="simulated world", remedy="trigger one")
                if cached is not None and cached[0] is setup:
                    return cached
                self._cached = (setup, simulate(setup))

    def leg(self) -> tuple[int, ShotResult]:
        """The present leg of an open-ended shot and the number of its first sample."""
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
        """Let an open-ended shot be known up to a sample, if it still runs."""
        while True:
            with self._lock:
                setup = self.setup
                if not self.running or self._feed is None or setup is None or self._leg_stop() >= stop_sample:
                    return
            _, result = self.result()
            with self._lock:
                if self.running and self.setup is setup:
                    self._next_leg(setup, result)

    def replan(self) -> None:
        """What an open-ended shot plays from now on is no longer what its feed said, or what it lasts if the present
        leg has not been computed yet."""
        with self._lock:
            if self.running and self._feed is not None and self.setup is not None:
                computed = self._cached is not None and self._cached[0] is self.setup
                samples = self.setup.timeline.total_samples if computed else None
                timeline = self._feed.timeline(self._leg_first, samples)
                if timeline != self.setup.timeline:
                    end_s = self.setup.start_s + timeline.duration_s
                    live = self._power.live_intervals(self.setup.start_s, end_s)
                    changed = replace(self.setup, timeline=timeline, stop_s=timeline.duration_s, live=live)
                    self.setup = changed.with_trip()

    def stop(self) -> None:
        """All outputs zero and lines low now: cut the running shot short, if there is one."""
        self.catch_up()
        with self._lock:
            if self.setup is None or not self.running:
                return
            elapsed = self._clock.monotonic_s() - self.setup.start_s
            if self._feed is not None:
                self._stop_open(elapsed)
                return
            if elapsed < self.setup.stop_s:
                self.setup = replace(self.setup, stop_s=max(elapsed, 1e-9))
            self._end_shot(self.setup)

    def refresh(self) -> None:
        """Let everything that has happened by now be seen."""
        self.catch_up()
        with self._lock:
            running = self.running
        if running:
            setup, result = self.result()
            with self._lock:
                if setup is self.setup:
                    self._show(setup, result, self._clock.monotonic_s() - setup.start_s)
                self.settle()

    def first(self) -> tuple[ShotSetup, ShotResult] | None:
        """The last shot, of an open-ended one its first leg; None before the first."""
        with self._lock:
            if self.setup is None:
                return None
        return self._first_leg or self.result()

    def relive(self) -> None:
        """The amplifier changed during the shot: the part still to come is different."""
        assert self.setup is not None
        start_s, stop_s = self.setup.start_s, self.setup.start_s + self.setup.timeline.duration_s
        changed = replace(self.setup, live=self._power.live_intervals(start_s, stop_s)).with_trip()
        if changed.powered() != self.setup.powered():
            self.setup = changed

    def settle(self) -> None:
        """If the running shot is over, make its end the state of the world."""
        setup = self.setup
        if setup is None or not self.running or self._feed is not None:
            return
        if self._clock.monotonic_s() >= setup.start_s + setup.stop_s:
            self._end_shot(setup)

    def catch_up(self) -> None:
        """Let an open-ended shot be known up to now."""
        with self._lock:
            running = self.running and self._feed is not None and self.setup is not None
            rate_hz = self.setup.timeline.clock.rate_hz if self.setup is not None else 0.0
            now = int((self._clock.monotonic_s() - self._begun_s) * rate_hz) + 1
        if running:
            self.extend(now)

    def _leg_stop(self) -> int:
        assert self.setup is not None
        return self._leg_first + self.setup.timeline.total_samples

    def _next_leg(self, setup: ShotSetup, result: ShotResult) -> None:
        """Go on from the end of a leg of an open-ended shot."""
        assert self._feed is not None
        self._show(setup, result, setup.stop_s)
        self._feed.leg_over(self._leg_first, result)
        end_s = setup.start_s + setup.stop_s
        self._witness.account(setup, result)
        self._leg_first = self._leg_stop()
        self._first_leg = self._first_leg or (setup, result)
        timeline = self._feed.timeline(self._leg_first)
        live = self._power.live_intervals(end_s, end_s + timeline.duration_s)
        self.setup, self._shown_s = after(setup, result, timeline, live), -np.inf

    def _stop_open(self, elapsed_s: float) -> None:
        """End the running leg of an open-ended shot."""
        assert self.setup is not None
        assert self._feed is not None
        stop_s = min(max(elapsed_s, 1e-9), self.setup.stop_s)
        if self._cached is not None and self._cached[0] is self.setup:
            self._cached = cut_short(*self._cached, stop_s)
        else:
            self._cached = self._finished(replace(self.setup, stop_s=stop_s))
        self.setup, result = self._cached
        self._feed.leg_over(self._leg_first, result)
        self._end_shot(self.setup)

    def _show(self, setup: ShotSetup, result: ShotResult, elapsed_s: float) -> None:
        """Let be seen, once each, what has become visible by `elapsed_s` after the trigger."""
        self._witness.seen(setup, result, self._shown_s, elapsed_s)
        self._shown_s = max(self._shown_s, elapsed_s)

    def _end_shot(self, setup: ShotSetup) -> None:
        self.running = False
        setup, result = self._finished(setup)
        self._witness.shot_over(setup, result)
        self._witness.account(setup, result)
        self._show(setup, result, setup.stop_s)

    def _finished(self, setup: ShotSetup) -> tuple[ShotSetup, ShotResult]:
        if self._cached is None or self._cached[0] is not setup:
            self._cached = (setup, simulate(setup))
        return self._cached
