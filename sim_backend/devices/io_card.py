"""The simulated real-time I/O card."""

from __future__ import annotations

import threading
from dataclasses import replace

import numpy as np

from drivers.errors import DeviceTimeout, InputError, SequenceRejected
from drivers.identity import Identity
from drivers.io_card import CardCapabilities, CardState, Chunk, ChunkFlags, require, was_stopped
from drivers.timeline import SampleClock, Timeline
from sim_backend.options import IoCardTable
from sim_backend.world.faults import DROPPED, FLAGS
from sim_backend.world.world import World

CHANNELS = 3
TIMEOUT_S = 1.0
WHERE = "simulated I/O card"


class SimulatedIoCard:
    """See drivers.io_card.IoCard.  Any thread may call any method."""

    def __init__(self, world: World, table: IoCardTable) -> None:
        self._world = world
        self._clock = SampleClock(table.base_frequency_hz, table.decimation)
        self._max_samples = table.max_samples
        self._step = table.step_samples
        self._step_v = table.output_step_v
        self._lock = threading.RLock()
        self._state = CardState.IDLE
        self._timeline: Timeline | None = None
        self._start_s = 0.0
        self._next = 0
        self._cancelled = threading.Event()

    def identity(self) -> Identity:
        """See IoCard."""
        return Identity("simulated", f"{CHANNELS} in / {self._outputs()} out sample-exact card")

    def capabilities(self) -> CardCapabilities:
        """See IoCard."""
        card = self._world.options.card
        return CardCapabilities(
            inputs=CHANNELS,
            outputs=self._outputs(),
            input_full_scale_v=card.input_full_scale_v,
            output_full_scale_v=card.output_full_scale_v,
            clock=self._clock,
            max_samples=self._max_samples,
            step_samples=self._step,
            output_step_v=self._step_v,
            retunes=True,
            holds_levels=True,
        )

    def state(self) -> CardState:
        """See IoCard."""
        return self._state

    def sample(self) -> int | None:
        """See IoCard."""
        with self._lock:
            if self._state is not CardState.RUNNING:
                return None
            return int((self._world.clock.monotonic_s() - self._start_s) * self._clock.rate_hz)

    def program(self, timeline: Timeline) -> None:
        """See IoCard."""
        with self._lock:
            require(self._state, CardState.IDLE, CardState.PROGRAMMED, where=WHERE)
            self._check(timeline)
            self._timeline = timeline
            self._state = CardState.PROGRAMMED

    def arm(self) -> None:
        """See IoCard."""
        with self._lock:
            require(self._state, CardState.PROGRAMMED, where=WHERE)
            self._state = CardState.ARMED

    def trigger(self) -> None:
        """See IoCard."""
        with self._lock:
            require(self._state, CardState.ARMED, where=WHERE)
            assert self._timeline is not None
            self._cancelled = threading.Event()
            self._start_s = self._world.start(self._quantised(self._timeline))
            self._next = 0
            self._state = CardState.RUNNING

    def _quantised(self, timeline: Timeline) -> Timeline:
        """The timeline with the amplitudes rounded to the steps of the card's registers."""
        if not self._step_v:
            return timeline
        nearest = [replace(b, amplitude_v=round(b.amplitude_v / self._step_v) * self._step_v) for b in timeline.bursts]
        return replace(timeline, bursts=tuple(nearest))

    def read(self, max_samples: int) -> Chunk:
        """See IoCard.  Waits until min(max_samples, samples left) have been taken."""
        if max_samples < 1:
            raise InputError(f"cannot read {max_samples} samples", where=WHERE, remedy="ask for one or more")
        with self._lock:
            require(self._state, CardState.RUNNING, where=WHERE)
            assert self._timeline is not None
            timeline = self._timeline
            first = self._next
            cancelled = self._cancelled
        setup, _ = self._world.shot_simulator.result()
        first, stop = self._span(timeline, setup.faults, first, max_samples)
        if not self._world.clock.wait_until(self._start_s + stop / self._clock.rate_hz, cancelled):
            raise was_stopped(WHERE)
        volts = self._world.shot_simulator.result()[1].received.volts[:, first:stop]
        with self._lock:
            if cancelled.is_set():
                raise was_stopped(WHERE)
            self._next = stop
            if stop == timeline.total_samples:
                self._world.is_running()  # ends the shot in the simulator, too, if it is over
                self._state = CardState.IDLE
        return Chunk(first, np.ascontiguousarray(volts), self._flags(timeline, setup.faults, first, stop))

    def stop(self) -> None:
        """See IoCard."""
        self._cancelled.set()
        with self._lock:
            if self._state is CardState.RUNNING:
                self._world.stop()
            if self._state is not CardState.CLOSED:
                self._state = CardState.IDLE
                self._timeline = None

    def close(self) -> None:
        """See IoCard."""
        self.stop()
        self._state = CardState.CLOSED

    def _span(self, timeline: Timeline, faults: frozenset[str], first: int, most: int) -> tuple[int, int]:
        """First sample and end of the next chunk, including the effects of faults.  Raises DeviceTimeout."""
        middle = timeline.total_samples // 2
        stop = min(first + most, timeline.total_samples)
        if "card_timeout" in faults and stop > middle:
            self._world.clock.sleep(TIMEOUT_S)
            raise DeviceTimeout(
                "no samples arrive",
                where=WHERE,
                why=f"sample {first} is overdue by {TIMEOUT_S} s",
                remedy="stop the card and repeat the shot; if it happens again, check card and cable",
            )
        if "dropped_samples" in faults and first < middle < stop:
            return first, middle
        if "dropped_samples" in faults and first == middle:
            first = min(middle + DROPPED, timeline.total_samples - 1)
            return first, min(first + most, timeline.total_samples)
        return first, stop

    @staticmethod
    def _flags(timeline: Timeline, faults: frozenset[str], first: int, stop: int) -> ChunkFlags:
        struck = first <= timeline.total_samples // 2 < stop
        return ChunkFlags(**{name: struck and name in faults for name in FLAGS})

    def _check(self, timeline: Timeline) -> None:
        """Raise SequenceRejected for a timeline that this card cannot play exactly."""
        full_scale_v = self._world.options.card.output_full_scale_v
        complaints = []
        if timeline.clock != self._clock:
            complaints.append(f"its clock is {self._clock}, not {timeline.clock}")
        if timeline.total_samples > self._max_samples:
            complaints.append(f"{timeline.total_samples} samples are more than {self._max_samples}")
        edges = [(b.start_sample, b.stop_sample) for b in timeline.bursts]
        edges += [(e.start_sample, e.stop_sample) for e in timeline.lines]
        if any(edge % self._step for pair in edges for edge in pair):
            complaints.append(f"its edges do not all lie on multiples of {self._step} samples")
        for burst in timeline.bursts:
            if not 0 <= burst.output < self._outputs():
                complaints.append(f"there is no output {burst.output}")
            if not 0 <= burst.frequency_hz < self._clock.rate_hz / 2:
                complaints.append(f"{burst.frequency_hz} Hz is outside 0 ... {self._clock.rate_hz / 2} Hz")
        for output in range(self._outputs()):
            peak_v = timeline.loudest_v(output)
            if not peak_v <= full_scale_v:
                complaints.append(f"output {output} would need {peak_v} V of {full_scale_v} V")
        if complaints:
            raise SequenceRejected(
                "the card cannot play this timeline",
                where=WHERE,
                why="; ".join(complaints),
                remedy="change the sequence, or the card's table in the platform file",
            )

    def _outputs(self) -> int:
        return CHANNELS + (self._world.spare_output is not None)
