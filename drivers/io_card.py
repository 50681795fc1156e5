"""Contract of the real-time I/O card: analog out, analog in and digital lines on one sample clock."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from drivers.errors import DeviceStateError
from drivers.identity import Identity
from drivers.timeline import DigitalLine, SampleClock, Timeline


@dataclass(frozen=True, kw_only=True)
class CardCapabilities:
    """What the card can do: number of analog inputs and outputs, full scales in V, sample clock, longest timeline.

    step_samples: every edge of a burst or line must lie on a multiple of it; line_delay_s: lines may change so
    much later than requested; output_step_v, frequency_step_hz: steps of the registers, a burst gets the nearest value
    (0: exact); unproved_lines: those that some cards of this kind cannot drive, to be proved before the first shot;
    input_ends_v: lowest and highest voltage of each input, empty: all have +- input_full_scale_v; retunes: one burst of
    an output may follow another with another frequency, amplitude or phase; holds_levels: it plays bursts of frequency
    0, which are constants.
    """

    inputs: int
    outputs: int
    input_full_scale_v: float
    output_full_scale_v: float
    clock: SampleClock
    max_samples: int
    step_samples: int = 1
    line_delay_s: float = 0.0
    output_step_v: float = 0.0
    frequency_step_hz: float = 0.0
    input_ends_v: tuple[tuple[float, float], ...] = ()
    retunes: bool = False
    holds_levels: bool = False
    unproved_lines: tuple[DigitalLine, ...] = ()

    def input_range_v(self, channel: int) -> tuple[float, float]:
        """The lowest and the highest voltage that an input can show."""
        full_v = self.input_full_scale_v
        return self.input_ends_v[channel] if self.input_ends_v else (-full_v, full_v)


class CardState(StrEnum):
    """Life of a card: IDLE -> program() -> PROGRAMMED -> arm() -> ARMED -> trigger() -> RUNNING -> IDLE."""

    IDLE = "idle"
    PROGRAMMED = "programmed"
    ARMED = "armed"
    RUNNING = "running"
    CLOSED = "closed"


def require(state: CardState, *allowed: CardState, where: str) -> None:
    """Raises DeviceStateError unless the card is in one of the states."""
    if state not in allowed:
        raise DeviceStateError(
            f"the card is {state.value}, not {' or '.join(s.value for s in allowed)}",
            where=where,
            remedy="keep the order program, arm, trigger, read; stop() makes the card idle",
        )


def was_stopped(where: str) -> DeviceStateError:
    """The error for a caller whose shot was stopped by another thread."""
    return DeviceStateError("the shot was stopped", where=where, remedy="program and start the shot again")


@dataclass(frozen=True)
class ChunkFlags:
    """The card's own verdict on a chunk; any True means the shot cannot be used as data.

    overwritten: the samples were overwritten before they were read; corrupted: overwritten while they were read;
    lost_steps: the output was late somewhere, so the excitation was not the requested one.
    """

    overwritten: bool = False
    corrupted: bool = False
    lost_steps: bool = False

    def names(self) -> tuple[str, ...]:
        """Names of the flags that are set."""
        return tuple(n for n in ("overwritten", "corrupted", "lost_steps") if getattr(self, n))

    def __or__(self, other: ChunkFlags) -> ChunkFlags:
        """Flags of both chunks together."""
        return ChunkFlags(
            self.overwritten or other.overwritten,
            self.corrupted or other.corrupted,
            self.lost_steps or other.lost_steps,
        )


@dataclass(frozen=True)
class Chunk:
    """A contiguous run of samples.

    first_sample: index of the first sample, counted by the card from the trigger (not by the reader);
    volts: (inputs, n) float32, V at the ADC input; flags: the card's verdict on exactly these samples.
    """

    first_sample: int
    volts: NDArray[np.float32]
    flags: ChunkFlags


class IoCard(Protocol):
    """Real-time I/O card.  Blocking; one owner thread, except `stop()`, which any thread may call at any time."""

    def identity(self) -> Identity:
        """Identity of the card, read from the card.  Raises DeviceTimeout, DeviceProtocolError."""

    def capabilities(self) -> CardCapabilities:
        """What the card can do; constant while it is open."""

    def state(self) -> CardState:
        """Where the card is in its life cycle."""

    def sample(self) -> int | None:
        """The sample that is being played and recorded now, by the card's own clock; None if nothing runs."""

    def program(self, timeline: Timeline) -> None:
        """Load a timeline.  Outputs stay zero and lines low.  Waits for a card that is still ending the previous shot.

        Allowed when IDLE or PROGRAMMED, else DeviceStateError.  Raises SequenceRejected if the card cannot play it
        exactly (clock, length, amplitude, output number, grid of edges): it never clamps, and rounds at most to the
        register steps in `capabilities()`.  DeviceLost if the connection broke: `stop()` makes a new one.
        """

    def arm(self) -> None:
        """Make ready for the trigger.  PROGRAMMED only, else DeviceStateError."""

    def trigger(self) -> None:
        """Start outputs, lines and recording together at sample 0.  ARMED only, else DeviceStateError.

        The caller has read the Tx/Rx switch back as TRANSMIT: moving contacts would lose the start of the drive.
        """

    def read(self, max_samples: int) -> Chunk:
        """Wait for and return the next samples, at most `max_samples`, at least one.

        The card's own filter delay is compensated to the nearest sample: sample k is the instant k / rate after the
        trigger.  The state becomes IDLE with the last sample.  Raises DeviceStateError if nothing is running (also
        after a stop), DeviceTimeout if no samples arrive, DeviceLost if the connection is lost, DeviceProtocolError
        on a reply that makes no sense, ShotRefused if the card's own account shows that this is not one recording.
        """

    def stop(self) -> None:
        """All outputs zero and all lines low, at once, in any state; the card is IDLE afterwards (CLOSED stays CLOSED).

        It reads back that outputs are off, over a new connection if the old one is broken, and raises DeviceError if
        it cannot.  A `read()` that waits meanwhile ends in DeviceStateError.
        """

    def close(self) -> None:
        """`stop()`, then release the card.  Idempotent."""
