"""The simulated world: one clamping unit with a rotor, the coils around it, and the state that all devices share.

Any thread may call any method.  `ClampingUnit` holds the rotor, `ShotSimulator` the running shot, `PowerStage` the
amplifier; the world connects them and records violations of the interlock and the intervals with power.
"""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from drivers.specimen import Specimen
from drivers.timeline import Timeline
from drivers.tx_rx_switch import SwitchPosition
from sim_backend.options import SimulatedOptions
from sim_backend.receive.reference_dipole import Dipole
from sim_backend.receive.relay_contacts import Contacts
from sim_backend.receive.shot_setup import MEMORY_S, ShotSetup
from sim_backend.rotor.decay import RotorState
from sim_backend.rotor.pieces import NO_INTERNAL_STATE
from sim_backend.rotor.rotor import effective
from sim_backend.transmit.coils import sensitivity_t_per_a
from sim_backend.transmit.drive import delivered_j
from sim_backend.transmit.power import OVER_CURRENT, OVER_TEMPERATURE, PowerStage

from .clamping_unit import ClampingUnit
from .clock import SimulatedClock
from .faults import FaultPlan
from .shot_simulator import SampleSource, ShotSimulator
from .variation import Temperature

if TYPE_CHECKING:
    from .shot import ShotResult  # loads the compiler, which a world without a shot does without

POWER_LOG = 4096  # spans
OVERLOAD_SEARCH_SAMPLES = 2**21  # samples: a longer leg is searched for overloads only if its samples are read
TEMPERATURE, THERMOMETER, HUM, FRICTION, IDLE_BOUNCE = 10, 11, 12, 13, 14


@dataclass(frozen=True, kw_only=True)
class Violation:
    """A failure of the interlock: world time, s, number of the shot, and cause."""

    time_s: float
    shot: int
    cause: str

    def as_dict(self) -> dict[str, Any]:
        """The violation as plain JSON types."""
        return {"time_s": self.time_s, "shot": self.shot, "cause": self.cause}


@dataclass(frozen=True, kw_only=True)
class PowerSpan:
    """An interval of a shot in which power could reach the coils, world time, s."""

    shot: int
    start_s: float
    stop_s: float


class World:
    """The state that all simulated devices share; each back end has one.

    >>> world = World(validated(SimulatedOptions, table["backends"]["simulated"], "backends.simulated"))
    >>> world.mount(specimen)
    >>> world.amplifier(enabled=True, muted=False)
    >>> world.start(timeline)
    >>> setup, result = world.shot_simulator.result()  # result.received.volts: (3, n) float32, V
    """

    def __init__(self, options: SimulatedOptions) -> None:
        self._own_options = options
        self.options = options  # with the effects of the mounted specimen
        self.clock = SimulatedClock(options.clock)
        self.lock = threading.RLock()
        self.power = PowerStage(options.amplifier)
        self.faults = FaultPlan(options.faults)
        lag_s = options.housing.thermal_time_constant_s
        self.temperature = Temperature(options.effects.temperature, self.rng(TEMPERATURE), lag_s)
        self.thermometer_rng = self.rng(THERMOMETER)
        self.unit = ClampingUnit(options)
        self.shot_simulator = ShotSimulator(self.clock, self.lock, self.power, self)
        self.lna_gain = options.lna.gains[0]
        self.lna_broken = False
        self.lna_overloaded = False
        self.shots = 0
        self.spare_output: int | None = None  # of the card: the output that feeds a reference dipole
        self._hum_phases = self.rng(HUM).uniform(0, 2 * np.pi, (len(options.noise.hum.amplitude_am2_per_s), 3))
        self._contacts = Contacts(options.switch)
        self._contacts_rng = self.rng(IDLE_BOUNCE)
        self._idle_gate = False
        self._idle_receive = False
        self._violations: list[Violation] = []
        self._power_log: deque[PowerSpan] = deque(maxlen=POWER_LOG)

    def rng(self, *stream: int) -> np.random.Generator:
        """Generator of one stream of random numbers, which depends on the seed only."""
        return np.random.default_rng([self.options.seed, *stream])

    # --- the content of the clamping unit

    def mount(self, specimen: Specimen) -> None:
        """Mount a resonator at rest, with the effects that it adds to the world; the same specimen as before keeps its
        present motion.  Raises ConfigError."""
        rotor = effective(specimen)
        options = self._own_options.with_effects_of(specimen)
        with self.lock:
            self.shot_simulator.finish_if_over()
            self.options = options
            self.unit.mount(specimen, rotor, options, self.clock.monotonic_s())

    def insert(self, dipole: Dipole | None, position_m: np.ndarray, *, empty: bool = False) -> None:
        """Replace the rotor by a dipole, or by a probe that induces no voltage (`empty`), at a position (3,), m.

        With neither, the rotor replaces the inserted device and is at rest.
        """
        with self.lock:
            self.shot_simulator.finish_if_over()
            self.unit.insert(dipole, position_m, self.clock.monotonic_s(), empty=empty)

    def hold_still(self) -> None:
        """Stop the rotor: it is at rest now."""
        with self.lock:
            self.shot_simulator.finish_if_over()
            self.unit.hold_still(self.clock.monotonic_s())

    def specimen(self) -> Specimen | None:
        """The mounted specimen; None: none."""
        with self.lock:
            return self.unit.specimen

    # --- shots

    def start(self, timeline: Timeline, source: SampleSource | None = None) -> float:
        """Start a timeline now; return the world time of sample 0, s.

        With a source the shot is open-ended: the timeline is its first leg, the source gives the next ones until
        `stop`.
        """
        with self.lock:
            self.shot_simulator.finish_if_over()
            now = self.clock.monotonic_s()
            self.shots += 1
            self._trip_if_too_hot(now)
            self._contacts = self._contacts.since(now - MEMORY_S)
            self.shot_simulator.begin(self._setup(timeline, source, now), source)
            return now

    def _setup(self, timeline: Timeline, source: SampleSource | None, now_s: float) -> ShotSetup:
        """The set-up of the shot that begins now."""
        closed = self._contacts.position(now_s) is SwitchPosition.TRANSMIT
        rotor_state = self.unit.decayed_until(now_s, closed=closed)
        rotor = self.unit.for_shot(now_s, self.temperature.inside_k(now_s), self.rng(FRICTION, self.shots))
        dipole, position_m = self.unit.source_and_position(rotor)
        return ShotSetup(
            options=self.options,
            number=self.shots,
            start_s=now_s,
            timeline=timeline,
            stop_s=timeline.duration_s,
            live=self.power.live_intervals(now_s, now_s + timeline.duration_s),
            contacts=self._contacts.shifted(-now_s),
            rotor=rotor,
            phi_rad=rotor_state.phi_rad,
            phi_dot_rad_per_s=rotor_state.phi_dot_rad_per_s,
            internal_state=NO_INTERNAL_STATE if rotor_state.internal_state is None else rotor_state.internal_state,
            sensitivity_t_per_a=sensitivity_t_per_a(self.options.coils, position_m),
            hum_phases_rad=self._hum_phases,
            lna_gain=self.lna_gain,
            lna_broken=self.lna_broken,
            faults=self.faults.at(self.shots),
            open_ended=source is not None,
            delay_s=0.0 if source is None else source.delay_s,
            dipole=dipole,
        )

    def stop(self) -> None:
        """Set all outputs to zero and all lines low now: truncate the running shot, if there is one."""
        self.shot_simulator.stop()

    # --- commands

    def amplifier(self, *, enabled: bool | None = None, muted: bool | None = None) -> None:
        """Enable, disable, mute or unmute now, also in the middle of a shot."""
        with self.lock:
            if self.power.set(self.clock.monotonic_s(), enabled=enabled, muted=muted) and self.shot_simulator.running:
                self.shot_simulator.amplifier_changed()
            self._check_idle()

    def trip_amplifier(self) -> None:
        """Latch a fault now; its cause does not last."""
        with self.lock:
            if self.power.trip(self.clock.monotonic_s(), OVER_CURRENT) and self.shot_simulator.running:
                self.shot_simulator.amplifier_changed()

    def reset_amplifier(self) -> str | None:
        """Disable, mute and clear the latched fault; return the fault whose cause still exists, None: there is none."""
        self.refresh()
        with self.lock:
            self.amplifier(enabled=False, muted=True)
            now = self.clock.monotonic_s()
            self.power.reset(now)
            self._trip_if_too_hot(now)
            return self.power.fault

    def idle_lines(self, *, pa_gate: bool, rx_connect: bool) -> None:
        """Set the levels of the digital lines while no shot runs; the contacts follow at once."""
        with self.lock:
            changed = rx_connect != self._idle_receive
            self._idle_gate = pa_gate
            self._idle_receive = rx_connect
            if changed and not self.shot_simulator.running:
                self.move_contacts(SwitchPosition.RECEIVE if rx_connect else SwitchPosition.TRANSMIT)
            self._check_idle()

    # --- read-back

    def contacts(self) -> Contacts:
        """The contacts' history in world time, running shot included."""
        self.shot_simulator.catch_up()
        with self.lock:
            setup = self.shot_simulator.setup
            if self.shot_simulator.running and setup is not None:
                from .shot import contacts_through_shot  # here: it loads the compiler

                return contacts_through_shot(setup).shifted(setup.start_s)
            return self._contacts

    def move_contacts(self, target: SwitchPosition) -> float:
        """Command the contacts while no shot runs; return the world time of their arrival, s."""
        with self.lock:
            self.shot_simulator.finish_if_over()
            self._contacts = self._contacts.command(self.clock.monotonic_s(), target, self._contacts_rng)
            self._check_idle()
            return self._contacts.arrival_s()

    def is_running(self) -> bool:
        """True while a shot runs."""
        with self.lock:
            self.shot_simulator.finish_if_over()
            return self.shot_simulator.running

    def refresh(self) -> None:
        """Update the read-backs (overload, clipping, trip) with all events up to now."""
        self.shot_simulator.refresh()

    def amplifier_temperature_c(self) -> float:
        """Temperature of the heat sink, deg C."""
        with self.lock:
            now = self.clock.monotonic_s()
            return self.temperature.celsius(now) + self.power.excess_k(now)

    def violations(self) -> tuple[Violation, ...]:
        """All violations of the interlock so far."""
        self.refresh()
        with self.lock:
            return tuple(self._violations)

    def power_log(self) -> tuple[PowerSpan, ...]:
        """Intervals in which power could reach the coils, of the last shots that have ended, ascending."""
        self.refresh()
        with self.lock:
            return tuple(self._power_log)

    def repair(self) -> None:
        """Repair all damage: a new LNA, free contacts; planned faults are removed."""
        with self.lock:
            self.shot_simulator.finish_if_over()
            self.faults.clear()
            self.lna_broken = self.lna_overloaded = False
            self._contacts = self._contacts.with_stuck(False)

    def truth(self) -> dict[str, Any] | None:
        """The truth of the last shot or its first leg, see `truth.record`; None before the first shot."""
        first = self.shot_simulator.first()
        if first is None:
            return None
        from .truth import record  # here: it loads the compiler

        setup, result = first
        violations = [self._violation(setup, t, cause).as_dict() for t, cause in result.violations]
        return record(setup, result, self.temperature.celsius(setup.start_s), violations)

    # --- Observer, called with the lock held

    def became_visible(self, setup: ShotSetup, result: ShotResult, since_s: float, until_s: float) -> None:
        """See Observer."""

        def new(time_s: float | None) -> bool:
            return time_s is not None and since_s < time_s <= until_s

        if setup.timeline.total_samples < OVERLOAD_SEARCH_SAMPLES or "received" in vars(result):
            self.lna_overloaded |= new(result.received.overload_s)
        self.power.clipped |= new(result.clipped_s)
        if "amplifier_trip" in setup.faults and new(setup.trip_s()):
            self.power.trip(setup.start_s + until_s, OVER_CURRENT)
        for t, cause in result.violations:
            if new(t):
                self._violations.append(self._violation(setup, t, cause))
                self.lna_broken = self.lna_overloaded = True

    def account_power(self, setup: ShotSetup, result: ShotResult) -> None:
        """See Observer."""
        self.power.heat(setup.start_s + setup.stop_s, delivered_j(result.cuts, self.options.coils.in_order()))
        for a, b in result.powered:
            span = PowerSpan(shot=setup.number, start_s=setup.start_s + a, stop_s=setup.start_s + b)
            self._power_log.append(span)

    def shot_ended(self, setup: ShotSetup, result: ShotResult) -> None:
        """See Observer."""
        end_s = setup.start_s + setup.stop_s
        self.unit.rotor_state = RotorState(
            time_s=end_s,
            phi_rad=result.phi_rad,
            phi_dot_rad_per_s=result.phi_dot_rad_per_s,
            internal_state=result.internal_state,
        )
        contacts = result.contacts.shifted(setup.start_s).with_options(self.options.switch)
        home = SwitchPosition.RECEIVE if self._idle_receive else SwitchPosition.TRANSMIT
        self._contacts = contacts.command(end_s, home, self._contacts_rng)

    @staticmethod
    def _violation(setup: ShotSetup, after_trigger_s: float, cause: str) -> Violation:
        return Violation(time_s=setup.start_s + after_trigger_s, shot=setup.number, cause=cause)

    def _trip_if_too_hot(self, now_s: float) -> None:
        if self.options.amplifier.trip_temperature_c < self.amplifier_temperature_c():
            self.power.trip(now_s, OVER_TEMPERATURE)

    def _check_idle(self) -> None:
        """Record a violation if power reaches the connected receiver while no shot runs."""
        gate_open = self._idle_gate and self.power.enabled and not self.power.muted and self.power.fault is None
        heading = self._contacts.heading() is SwitchPosition.RECEIVE
        if gate_open and heading and not self.shot_simulator.running and not self.lna_broken:
            now = max(self.clock.monotonic_s(), self._contacts.arrival_s())
            cause = "receiver connected to the live amplifier while idle"
            self._violations.append(Violation(time_s=now, shot=self.shots, cause=cause))
            self.lna_broken = self.lna_overloaded = True
