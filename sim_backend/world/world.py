"""The simulated world: one clamping unit with a rotor in it, coils around it, and the devices' common reality.

Everything here is thread-safe.  What sits in the unit is `ClampingUnit`, the shot that runs `Player`, the amplifier
`PowerStage`; the world joins them, and keeps what happened.
"""

from __future__ import annotations

import threading
from collections import deque
from typing import Any

import numpy as np

from drivers.specimen import Specimen
from drivers.timeline import Timeline
from drivers.tx_rx_switch import SwitchPosition
from sim_backend.options import SimulatedOptions
from sim_backend.receive.contacts import Contacts
from sim_backend.receive.reference_dipole import Dipole
from sim_backend.receive.shot_setup import ShotSetup
from sim_backend.rotor.decay import Resting
from sim_backend.rotor.hidden import NONE
from sim_backend.rotor.rotor import effective
from sim_backend.transmit.coils import sensitivity_t_per_a
from sim_backend.transmit.drive import delivered_j
from sim_backend.transmit.power import OVER_CURRENT, OVER_TEMPERATURE, PowerStage

from .clamping_unit import ClampingUnit
from .clock import SimulatedClock
from .faults import FaultPlan
from .incidents import PowerSpan, Violation
from .player import Feed, Player
from .shot import MEMORY_S, ShotResult, commanded
from .truth import record
from .variation import Temperature

POWER_LOG = 4096  # spans
LISTEN_TO = 2**21  # samples: a longer leg is searched for overloads only if somebody reads it
TEMPERATURE, THERMOMETER, HUM, FRICTION, IDLE_BOUNCE = 10, 11, 12, 13, 14


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
        self.unit = ClampingUnit(options)
        self.player = Player(self.clock, self.lock, self.power, self)
        self.lna_gain = options.lna.gains[0]
        self.lna_broken = False
        self.lna_overloaded = False
        self.shots = 0
        self.spare_output: int | None = None  # of the card: what a reference dipole hangs on
        self._hum_phases = self.rng(HUM).uniform(0, 2 * np.pi, (len(options.noise.hum.amplitude_am2_per_s), 3))
        self._contacts = Contacts(options.switch)
        self._contacts_rng = self.rng(IDLE_BOUNCE)
        self._idle_gate = self._idle_receive = False
        self._violations: list[Violation] = []
        self._power_log: deque[PowerSpan] = deque(maxlen=POWER_LOG)

    def rng(self, *stream: int) -> np.random.Generator:
        """Random numbers of their own stream, from the seed alone."""
        return np.random.default_rng([self.options.seed, *stream])

    # --- what sits in the clamping unit

    def mount(self, specimen: Specimen) -> None:
        """Put a resonator in; at rest unless it is the one already there, which goes on as it is."""
        rotor = effective(specimen)
        with self.lock:
            self.player.settle()
            self.unit.mount(specimen, rotor, self.clock.monotonic_s())

    def insert(self, dipole: Dipole | None, position_m: np.ndarray, *, empty: bool = False) -> None:
        """Take the rotor out and put a dipole, or a probe that leaves the receiver alone (`empty`), in its place; with
        neither, whatever stood there goes and the rotor comes back to rest."""
        with self.lock:
            self.player.settle()
            self.unit.insert(dipole, position_m, self.clock.monotonic_s(), empty=empty)

    def hold_still(self) -> None:
        """Let the rotor hang at rest now, as if a finger had stopped it."""
        with self.lock:
            self.player.settle()
            self.unit.hold_still(self.clock.monotonic_s())

    def specimen(self) -> Specimen | None:
        """What is mounted."""
        with self.lock:
            return self.unit.specimen

    # --- shots

    def start(self, timeline: Timeline, feed: Feed | None = None) -> float:
        """Trigger: the timeline starts now; returns the world time of sample 0.

        With a feed the shot is open-ended: the timeline is its first leg, the feed has the next ones, until `stop`.
        """
        with self.lock:
            self.player.settle()
            now = self.clock.monotonic_s()
            self.shots += 1
            self._trip_if_too_hot(now)
            self._contacts = self._contacts.since(now - MEMORY_S)
            self.player.begin(self._setup(timeline, feed, now), feed)
            return now

    def _setup(self, timeline: Timeline, feed: Feed | None, now_s: float) -> ShotSetup:
        """The shot that begins now."""
        closed = self._contacts.position(now_s) is SwitchPosition.TRANSMIT
        resting = self.unit.rest_until(now_s, closed=closed)
        rotor = self.unit.for_shot(self.temperature.deviation_k(now_s), self.rng(FRICTION, self.shots))
        dipole, where = self.unit.seen_from_coils(rotor)
        return ShotSetup(
            options=self.options,
            number=self.shots,
            start_s=now_s,
            timeline=timeline,
            stop_s=timeline.duration_s,
            live=self.power.live_intervals(now_s, now_s + timeline.duration_s),
            contacts=self._contacts.shifted(-now_s),
            rotor=rotor,
            phi_rad=resting.phi_rad,
            phi_dot_rad_per_s=resting.phi_dot_rad_per_s,
            hidden=NONE if resting.hidden is None else resting.hidden,
            sensitivity_t_per_a=sensitivity_t_per_a(self.options.coils, where),
            hum_phases_rad=self._hum_phases,
            lna_gain=self.lna_gain,
            lna_broken=self.lna_broken,
            faults=self.faults.at(self.shots),
            open_ended=feed is not None,
            delay_s=0.0 if feed is None else feed.delay_s,
            dipole=dipole,
        )

    def stop(self) -> None:
        """All outputs zero and lines low now: cut the running shot short, if there is one."""
        self.player.stop()

    # --- commands

    def amplifier(self, *, enabled: bool | None = None, muted: bool | None = None) -> None:
        """Enable, disable, mute or unmute now, also in the middle of a shot."""
        with self.lock:
            if self.power.set(self.clock.monotonic_s(), enabled=enabled, muted=muted) and self.player.running:
                self.player.relive()
            self._check_idle()

    def trip_amplifier(self) -> None:
        """Latch a fault now whose cause is gone at once."""
        with self.lock:
            if self.power.trip(self.clock.monotonic_s(), OVER_CURRENT) and self.player.running:
                self.player.relive()

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
            if changed and not self.player.running:
                self.move_contacts(SwitchPosition.RECEIVE if rx_connect else SwitchPosition.TRANSMIT)
            self._check_idle()

    # --- read-back

    def contacts(self) -> Contacts:
        """The contacts' history in world time, running shot included."""
        self.player.catch_up()
        with self.lock:
            setup = self.player.setup
            if self.player.running and setup is not None:
                return commanded(setup).shifted(setup.start_s)
            return self._contacts

    def move_contacts(self, target: SwitchPosition) -> float:
        """Command the contacts outside a timeline; returns the world time of arrival."""
        with self.lock:
            self.player.settle()
            self._contacts = self._contacts.command(self.clock.monotonic_s(), target, self._contacts_rng)
            self._check_idle()
            return self._contacts.arrival_s()

    def is_running(self) -> bool:
        """True while a timeline is being played."""
        with self.lock:
            self.player.settle()
            return self.player.running

    def refresh(self) -> None:
        """Let everything that has happened by now show in the read-backs (overload, clipping, trip)."""
        self.player.refresh()

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
            self.player.settle()
            self.faults.clear()
            self.lna_broken = self.lna_overloaded = False
            self._contacts = self._contacts.jam(False)

    def truth(self) -> dict[str, Any] | None:
        """The record of the last shot, of its first leg if it is open-ended; None before the first."""
        first = self.player.first()
        if first is None:
            return None
        setup, result = first
        happened = [Violation(setup.start_s + t, setup.number, cause).as_dict() for t, cause in result.violations]
        return record(setup, result, self.temperature.celsius(setup.start_s), happened)

    # --- what the player tells, inside the lock

    def seen(self, setup: ShotSetup, result: ShotResult, since_s: float, until_s: float) -> None:
        """See Witness."""

        def new(time_s: float | None) -> bool:
            return time_s is not None and since_s < time_s <= until_s

        if setup.timeline.total_samples < LISTEN_TO or "heard" in vars(result):
            self.lna_overloaded |= new(result.heard.overload_s)
        self.power.clipped |= new(result.clipped_s)
        if "amplifier_trip" in setup.faults and new(setup.trip_s()):
            self.power.trip(setup.start_s + until_s, OVER_CURRENT)
        for t, cause in result.violations:
            if new(t):
                self._violations.append(Violation(setup.start_s + t, setup.number, cause))
                self.lna_broken = self.lna_overloaded = True

    def account(self, setup: ShotSetup, result: ShotResult) -> None:
        """See Witness."""
        self.power.heat(setup.start_s + setup.stop_s, delivered_j(result.cuts, self.options.coils.in_order()))
        for a, b in result.powered:
            self._power_log.append(PowerSpan(setup.number, setup.start_s + a, setup.start_s + b))

    def shot_over(self, setup: ShotSetup, result: ShotResult) -> None:
        """See Witness."""
        end_s = setup.start_s + setup.stop_s
        self.unit.resting = Resting(end_s, result.phi_rad, result.phi_dot_rad_per_s, result.hidden)
        contacts = result.contacts.shifted(setup.start_s).like(self.options.switch)
        home = SwitchPosition.RECEIVE if self._idle_receive else SwitchPosition.TRANSMIT
        self._contacts = contacts.command(end_s, home, self._contacts_rng)

    def _trip_if_too_hot(self, now_s: float) -> None:
        if self.options.amplifier.trip_temperature_c < self.amplifier_temperature_c():
            self.power.trip(now_s, OVER_TEMPERATURE)

    def _check_idle(self) -> None:
        """Without a shot: power on the connected receiver is a violation as well."""
        gate_open = self._idle_gate and self.power.enabled and not self.power.muted and self.power.fault is None
        heading = self._contacts.heading() is SwitchPosition.RECEIVE
        if gate_open and heading and not self.player.running and not self.lna_broken:
            now = max(self.clock.monotonic_s(), self._contacts.arrival_s())
            self._violations.append(Violation(now, self.shots, "receiver connected to the live amplifier while idle"))
            self.lna_broken = self.lna_overloaded = True
