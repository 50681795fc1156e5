"""The simulated world: one clamping unit with a rotor in it, coils around it, and the devices' common reality.

Everything here is thread-safe.  A shot is computed when somebody first needs it, outside the lock, so that stopping and
reading the status never wait for it.
"""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from drivers.errors import DeviceFault
from drivers.specimen import Specimen
from drivers.timeline import Timeline
from drivers.tx_rx_switch import SwitchPosition
from sim_backend.clock import SimulatedClock
from sim_backend.coils import sensitivity_t_per_a
from sim_backend.contacts import Contacts
from sim_backend.decay import Resting, at_rest, decayed
from sim_backend.drive import delivered_j
from sim_backend.faults import FaultPlan
from sim_backend.hidden import NONE
from sim_backend.inserted import Dipole
from sim_backend.options import SimulatedOptions
from sim_backend.power import OVER_CURRENT, OVER_TEMPERATURE, PowerStage
from sim_backend.rotor import Rotor, effective
from sim_backend.shot import ShotResult, after, commanded, conductance, cut_short, simulate
from sim_backend.shot_setup import ShotSetup
from sim_backend.torque import parameters
from sim_backend.truth import record
from sim_backend.variation import Temperature, friction_factor, rotor_now

POWER_LOG = 4096  # spans
LISTEN_TO = 2**21  # samples: a longer leg is searched for overloads only if somebody reads it
TEMPERATURE, THERMOMETER, HUM, FRICTION, IDLE_BOUNCE = 10, 11, 12, 13, 14


@dataclass(frozen=True)
class Violation:
    """The interlock failed: world time s, number of the shot, and what happened."""

    time_s: float
    shot: int
    cause: str

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON types."""
        return {"time_s": self.time_s, "shot": self.shot, "cause": self.cause}


@dataclass(frozen=True)
class PowerSpan:
    """Power could reach the coils from `start_s` to `stop_s` (world time) in a shot."""

    shot: int
    start_s: float
    stop_s: float


class Feed(Protocol):
    """Where an open-ended shot gets what is played and hands over what is heard; samples are counted from the trigger.

    delay_s: of the record, see `ShotSetup`.  Called with the world's lock held.
    """

    delay_s: float

    def timeline(self, first_sample: int, samples: int | None = None) -> Timeline:
        """What will be played from a sample on, as far as is known now; None: for as long as the feed likes."""

    def leg_over(self, first_sample: int, result: ShotResult) -> None:
        """A leg is over."""


class World:
    """What all simulated devices share.  Built once per back end."""

    def __init__(self, options: SimulatedOptions) -> None:
        self.options = options
        self.clock = SimulatedClock(options.clock)
        self.lock = threading.RLock()
        self.power = PowerStage(options.amplifier)
        self.faults = FaultPlan(options.faults)
        self.temperature = Temperature(options.effects.temperature, self.rng(TEMPERATURE))
        self.thermometer_rng = self.rng(THERMOMETER)
        self.lna_gain = options.lna.gains[0]
        self.lna_broken = False
        self.lna_overloaded = False
        self.shots = 0
        self._hum_phases = self.rng(HUM).uniform(0, 2 * np.pi, (len(options.noise.hum.amplitude_am2_per_s), 3))
        self._contacts = Contacts(options.switch)
        self._contacts_rng = self.rng(IDLE_BOUNCE)
        self._specimen: Specimen | None = None
        self._rotor: Rotor | None = None
        self.spare_output: int | None = None  # of the card: what a reference dipole hangs on
        self._instead: tuple[Dipole | None, np.ndarray] | None = None  # of the rotor, and where
        self._worn: dict[str, int] = {}
        self._resting = Resting()
        self._setup: ShotSetup | None = None
        self._running = False
        self._feed: Feed | None = None
        self._begun_s, self._leg_first = 0.0, 0
        self._first_leg: tuple[ShotSetup, ShotResult] | None = None
        self._idle_gate = self._idle_receive = False
        self._shown_s = -np.inf
        self._compute = threading.Lock()
        self._cached: tuple[ShotSetup, ShotResult] | None = None
        self._violations: list[Violation] = []
        self._power_log: deque[PowerSpan] = deque(maxlen=POWER_LOG)

    def rng(self, *stream: int) -> np.random.Generator:
        """Random numbers of their own stream, from the seed alone."""
        return np.random.default_rng([self.options.seed, *stream])

    # --- rotor

    def mount(self, specimen: Specimen) -> None:
        """Put a resonator in; at rest unless it is the one already there, which goes on as it is."""
        rotor = effective(specimen)
        with self.lock:
            self._settle()
            self._instead = None
            if specimen != self._specimen:
                self._resting = self._at_rest(rotor)
                self._specimen, self._rotor = specimen, rotor

    def insert(self, dipole: Dipole | None, position_m: np.ndarray, *, empty: bool = False) -> None:
        """Take the rotor out and put a dipole, or a probe that leaves the receiver alone (`empty`), in its place; with
        neither, whatever stood there goes and the rotor comes back to rest."""
        with self.lock:
            self._settle()
            self._instead = (dipole, position_m) if dipole is not None or empty else None
            if self._rotor is not None:
                self._resting = self._at_rest(self._rotor)

    def hold_still(self) -> None:
        """Let the rotor hang at rest now, as if a finger had stopped it."""
        with self.lock:
            self._settle()
            if self._rotor is not None:
                self._resting = self._at_rest(self._rotor)

    def specimen(self) -> Specimen | None:
        """What is mounted."""
        with self.lock:
            return self._specimen

    # --- shots

    def start(self, timeline: Timeline, feed: Feed | None = None) -> float:
        """Trigger: the timeline starts now; returns the world time of sample 0.

        With a feed the shot is open-ended: the timeline is its first leg, the feed has the next ones, until `stop`.
        """
        with self.lock:
            self._settle()
            now = self.clock.monotonic_s()
            self.shots += 1
            faults = self.faults.at(self.shots)
            self._trip_if_too_hot(now)
            rotor, resting = self._rotor_for_shot(now), self._rest_until(now)
            dipole, where = self._instead or (None, rotor.position_m if rotor else np.zeros(3))
            self._setup = ShotSetup(
                options=self.options,
                number=self.shots,
                start_s=now,
                timeline=timeline,
                stop_s=timeline.duration_s,
                live=self.power.live_intervals(now, now + timeline.duration_s),
                contacts=self._contacts.shifted(-now),
                rotor=rotor,
                phi_rad=resting.phi_rad,
                phi_dot_rad_per_s=resting.phi_dot_rad_per_s,
                hidden=NONE if resting.hidden is None else resting.hidden,
                sensitivity_t_per_a=sensitivity_t_per_a(self.options.coils, where),
                hum_phases_rad=self._hum_phases,
                lna_gain=self.lna_gain,
                lna_broken=self.lna_broken,
                faults=faults,
                open_ended=feed is not None,
                delay_s=0.0 if feed is None else feed.delay_s,
                dipole=dipole,
            )
            self._setup = self._setup.with_trip()
            self._running, self._shown_s = True, -np.inf
            self._feed, self._begun_s, self._leg_first, self._first_leg = feed, now, 0, None
            return now

    def result(self) -> tuple[ShotSetup, ShotResult]:
        """The last shot made or begun.  Raises DeviceFault if there is none."""
        with self._compute:
            while True:
                with self.lock:
                    setup = self._setup
                    if setup is None:
                        raise DeviceFault("no shot has been made yet", where="simulated world", remedy="trigger one")
                    if self._cached is not None and self._cached[0] is setup:
                        return self._cached
                cached = (setup, simulate(setup))
                with self.lock:
                    self._cached = cached

    def leg(self) -> tuple[int, ShotResult]:
        """The present leg of an open-ended shot and the number of its first sample."""
        while True:
            setup, result = self.result()
            with self.lock:
                if setup is self._setup:
                    return self._leg_first, result

    def leg_first(self) -> int:
        """Number of the first sample of the present leg."""
        with self.lock:
            return self._leg_first

    def extend(self, stop_sample: int) -> None:
        """Let an open-ended shot be known up to a sample, if it still runs."""
        while True:
            with self.lock:
                setup = self._setup
                if not self._running or self._feed is None or setup is None or self._leg_stop() >= stop_sample:
                    return
            _, result = self.result()
            with self.lock:
                if self._running and self._setup is setup:
                    self._next_leg(setup, result)

    def replan(self) -> None:
        """What an open-ended shot plays from now on is no longer what its feed said, or what it lasts if the present
        leg has not been computed yet."""
        with self.lock:
            if self._running and self._feed is not None and self._setup is not None:
                computed = self._cached is not None and self._cached[0] is self._setup
                samples = self._setup.timeline.total_samples if computed else None
                timeline = self._feed.timeline(self._leg_first, samples)
                if timeline != self._setup.timeline:
                    end_s = self._setup.start_s + timeline.duration_s
                    live = self.power.live_intervals(self._setup.start_s, end_s)
                    changed = replace(self._setup, timeline=timeline, stop_s=timeline.duration_s, live=live)
                    self._setup = changed.with_trip()

    def stop(self) -> None:
        """All outputs zero and lines low now: cut the running shot short, if there is one."""
        self._catch_up()
        with self.lock:
            if self._setup is None or not self._running:
                return
            elapsed = self.clock.monotonic_s() - self._setup.start_s
            if self._feed is not None:
                self._stop_open(elapsed)
                return
            if elapsed < self._setup.stop_s:
                self._setup = replace(self._setup, stop_s=max(elapsed, 1e-9))
            self._end_shot(self._setup)

    def amplifier(self, *, enabled: bool | None = None, muted: bool | None = None) -> None:
        """Enable, disable, mute or unmute now, also in the middle of a shot."""
        with self.lock:
            if self.power.set(self.clock.monotonic_s(), enabled=enabled, muted=muted) and self._running:
                self._relive()
            self._check_idle()

    def trip_amplifier(self) -> None:
        """Latch a fault now whose cause is gone at once."""
        with self.lock:
            if self.power.trip(self.clock.monotonic_s(), OVER_CURRENT) and self._running:
                self._relive()

    def reset_amplifier(self) -> str | None:
        """Disable, mute and clear the latched fault; the one that stays because its cause does, None: all is well."""
        self.refresh()
        with self.lock:
            self.amplifier(enabled=False, muted=True)
            now = self.clock.monotonic_s()
            self.power.reset(now)
            self._trip_if_too_hot(now)
            return self.power.fault

    def idle_lines(self, *, pa_gate: bool, rx_connect: bool) -> None:
        """Levels of the digital lines while nothing is played; the contacts follow at once."""
        with self.lock:
            self._idle_gate, changed = pa_gate, rx_connect != self._idle_receive
            self._idle_receive = rx_connect
            if changed and not self._running:
                self.move_contacts(SwitchPosition.RECEIVE if rx_connect else SwitchPosition.TRANSMIT)
            self._check_idle()

    # --- read-back

    def contacts(self) -> Contacts:
        """The contacts' history in world time, running shot included."""
        self._catch_up()
        with self.lock:
            if self._running and self._setup is not None:
                return commanded(self._setup).shifted(self._setup.start_s)
            return self._contacts

    def move_contacts(self, target: SwitchPosition) -> float:
        """Command the contacts outside a timeline; returns the world time of arrival."""
        with self.lock:
            self._settle()
            self._contacts = self._contacts.command(self.clock.monotonic_s(), target, self._contacts_rng)
            self._check_idle()
            return self._contacts.arrival_s()

    def is_running(self) -> bool:
        """True while a timeline is being played."""
        with self.lock:
            self._settle()
            return self._running

    def refresh(self) -> None:
        """Let everything that has happened by now show in the read-backs (overload, clipping, trip)."""
        self._catch_up()
        with self.lock:
            running = self._running
        if running:
            setup, result = self.result()
            with self.lock:
                if setup is self._setup:
                    self._show(setup, result, self.clock.monotonic_s() - setup.start_s)
                self._settle()

    def amplifier_temperature_c(self) -> float:
        """Temperature of the heat sink, deg C."""
        with self.lock:
            now = self.clock.monotonic_s()
            return self.temperature.celsius(now) + self.power.excess_k(now)

    def violations(self) -> tuple[Violation, ...]:
        """Every time the interlock failed so far."""
        self.refresh()
        with self.lock:
            return tuple(self._violations)

    def power_log(self) -> tuple[PowerSpan, ...]:
        """When power could reach the coils in the last shots, as far as they are over, rising."""
        self.refresh()
        with self.lock:
            return tuple(self._power_log)

    def repair(self) -> None:
        """Replace what broke: a new LNA, freed contacts, no more faults to come."""
        with self.lock:
            self._settle()
            self.faults.clear()
            self.lna_broken = self.lna_overloaded = False
            self._contacts = self._contacts.jam(False)

    def truth(self) -> dict[str, Any] | None:
        """The record of the last shot, of its first leg if it is open-ended; None before the first."""
        with self.lock:
            if self._setup is None:
                return None
        setup, result = self._first_leg or self.result()
        happened = [Violation(setup.start_s + t, setup.number, cause).as_dict() for t, cause in result.violations]
        return record(setup, result, self.temperature.celsius(setup.start_s), happened)

    # --- inside the lock

    def _trip_if_too_hot(self, now_s: float) -> None:
        if self.options.amplifier.trip_temperature_c < self.amplifier_temperature_c():
            self.power.trip(now_s, OVER_TEMPERATURE)

    def _at_rest(self, rotor: Rotor) -> Resting:
        return at_rest(self.clock.monotonic_s(), parameters(rotor, undeclared=self.options.undeclared))

    def _rotor_for_shot(self, now_s: float) -> Rotor | None:
        if self._rotor is None or self._specimen is None or self._instead is not None:
            return None
        worn = self._worn.get(self._specimen.name, 0)
        self._worn[self._specimen.name] = worn + 1
        factor = friction_factor(self.options.effects, self.rng(FRICTION, self.shots), worn)
        return rotor_now(self._rotor, self.options.effects, self.temperature.deviation_k(now_s), factor)

    def _rest_until(self, now_s: float) -> Resting:
        """The rotor now, after its free decay since the last shot."""
        rotor = self._setup.rotor if self._setup and self._setup.rotor else self._rotor
        if rotor is None or self._instead is not None:
            return Resting(now_s)
        closed = self._contacts.position(now_s) is SwitchPosition.TRANSMIT
        along_uv = sensitivity_t_per_a(self.options.coils, rotor.position_m) @ rotor.rotation[:, :2]
        braking = conductance(self.options, rotor, along_uv) if closed else None
        return decayed(self._resting, now_s, rotor, braking, self.options.undeclared)

    def _relive(self) -> None:
        """The amplifier changed during the shot: the part still to come is different."""
        assert self._setup is not None
        start_s, stop_s = self._setup.start_s, self._setup.start_s + self._setup.timeline.duration_s
        changed = replace(self._setup, live=self.power.live_intervals(start_s, stop_s)).with_trip()
        if changed.powered() != self._setup.powered():
            self._setup = changed

    def _show(self, setup: ShotSetup, result: ShotResult, elapsed_s: float) -> None:
        """Latch, once each, what has become visible by `elapsed_s` after the trigger."""

        def new(time_s: float | None) -> bool:
            return time_s is not None and self._shown_s < time_s <= elapsed_s

        if setup.timeline.total_samples < LISTEN_TO or "heard" in vars(result):
            self.lna_overloaded |= new(result.heard.overload_s)
        self.power.clipped |= new(result.clipped_s)
        if "amplifier_trip" in setup.faults and new(setup.trip_s()):
            self.power.trip(setup.start_s + elapsed_s, OVER_CURRENT)
        for t, cause in result.violations:
            if new(t):
                self._violations.append(Violation(setup.start_s + t, setup.number, cause))
                self.lna_broken = self.lna_overloaded = True
        self._shown_s = max(self._shown_s, elapsed_s)

    def _settle(self) -> None:
        """If the running shot is over, make its end the state of the world."""
        setup = self._setup
        if (
            setup is None
            or not self._running
            or self._feed is not None
            or self.clock.monotonic_s() < setup.start_s + setup.stop_s
        ):
            return
        self._end_shot(setup)

    def _catch_up(self) -> None:
        """Let an open-ended shot be known up to now."""
        with self.lock:
            running = self._running and self._feed is not None and self._setup is not None
            rate_hz = self._setup.timeline.clock.rate_hz if self._setup is not None else 0.0
            now = int((self.clock.monotonic_s() - self._begun_s) * rate_hz) + 1
        if running:
            self.extend(now)

    def _leg_stop(self) -> int:
        assert self._setup is not None
        return self._leg_first + self._setup.timeline.total_samples

    def _next_leg(self, setup: ShotSetup, result: ShotResult) -> None:
        """Go on from the end of a leg of an open-ended shot."""
        assert self._feed is not None
        self._show(setup, result, setup.stop_s)
        self._feed.leg_over(self._leg_first, result)
        end_s = setup.start_s + setup.stop_s
        self._account(setup, result)
        self._leg_first = self._leg_stop()
        self._first_leg = self._first_leg or (setup, result)
        timeline = self._feed.timeline(self._leg_first)
        live = self.power.live_intervals(end_s, end_s + timeline.duration_s)
        self._setup, self._shown_s = after(setup, result, timeline, live), -np.inf

    def _stop_open(self, elapsed_s: float) -> None:
        """End the running leg of an open-ended shot."""
        assert self._setup is not None
        assert self._feed is not None
        stop_s = min(max(elapsed_s, 1e-9), self._setup.stop_s)
        if self._cached is not None and self._cached[0] is self._setup:
            self._cached = cut_short(*self._cached, stop_s)
        else:
            self._cached = self._finished(replace(self._setup, stop_s=stop_s))
        self._setup, result = self._cached
        self._feed.leg_over(self._leg_first, result)
        self._end_shot(self._setup)

    def _check_idle(self) -> None:
        """Without a shot: power on the connected receiver is a violation as well."""
        gate_open = self._idle_gate and self.power.enabled and not self.power.muted and self.power.fault is None
        heading = self._contacts.heading() is SwitchPosition.RECEIVE
        if gate_open and heading and not self._running and not self.lna_broken:
            now = max(self.clock.monotonic_s(), self._contacts.arrival_s())
            self._violations.append(Violation(now, self.shots, "receiver connected to the live amplifier while idle"))
            self.lna_broken = self.lna_overloaded = True

    def _end_shot(self, setup: ShotSetup) -> None:
        """Make the end of the shot the state of the world."""
        end_s = setup.start_s + setup.stop_s
        self._running = False
        setup, result = self._finished(setup)
        self._resting = Resting(end_s, result.phi_rad, result.phi_dot_rad_per_s, result.hidden)
        contacts = result.contacts.shifted(setup.start_s).like(self.options.switch)
        home = SwitchPosition.RECEIVE if self._idle_receive else SwitchPosition.TRANSMIT
        self._contacts = contacts.command(end_s, home, self._contacts_rng)
        self._account(setup, result)
        self._show(setup, result, setup.stop_s)

    def _account(self, setup: ShotSetup, result: ShotResult) -> None:
        """Heat and power of what is over."""
        self.power.heat(setup.start_s + setup.stop_s, delivered_j(result.cuts, self.options.coils.in_order()))
        for a, b in result.powered:
            self._power_log.append(PowerSpan(setup.number, setup.start_s + a, setup.start_s + b))

    def _finished(self, setup: ShotSetup) -> tuple[ShotSetup, ShotResult]:
        if self._cached is None or self._cached[0] is not setup:
            self._cached = (setup, simulate(setup))
        return self._cached
