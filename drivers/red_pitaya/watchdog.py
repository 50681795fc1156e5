"""The card's own watchdog for a shot that stays in its memory: a wire from DIO4_N to DIO3_P of each card.

A counter of the card begins with the trigger and puts its third bit on DIO4_N, high after 4 steps of
`COUNTER:SAMPLESPERSTEP` (Verilog: sequence_stepper.v, ORed onto the pin in bd.tcl).  By the wire that presses the
card's own emergency input, which holds all outputs at zero until the trigger falls (reset_manager.v), whatever has
become of the server, the network and this computer.  The counter takes its step while it is held in reset, so that it
cannot be changed in a shot.  Its first and second bit are on DIO2_N and DIO3_N.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from drivers.errors import DeviceError, DeviceFault, DeviceProtocolError, SequenceRejected
from drivers.red_pitaya.connection import Value
from drivers.red_pitaya.emergency import EMERGENCY_PIN
from drivers.red_pitaya.layout import DIGITAL_PINS, pin_header
from drivers.red_pitaya.sequence import LONGEST_STEP, BoardProgram

WIRE_PIN = "DIO4_N"
COUNTER_PINS = ("DIO2_N", "DIO3_N")  # carry the counter's pulses, too, if they are outputs
STEPS = 4  # of the counter until the wire is high
WRITTEN_STEPS = 7372  # of the memory; what the server writes, beyond the shot's end disabled and zero
COUNTER_CLOCKS = 2**31  # what its register takes
LATE_S = 0.5  # how late this computer may be for the end of a shot: before that the input is pressed by nobody else
LEAST_LATE_S = 0.05
MISSING = "the watchdog's wire from DIO4_N to DIO3_P is missing"
REMEDY = "connect DIO4_N to DIO3_P on this card, by a wire of its own, or set io_card.replay_watchdog = false"

Ask = Callable[..., list[Value]]


def counter_step(programs: Sequence[BoardProgram], recorded: int, rate_hz: float, decimation: int) -> int:
    """Samples per step of the counter, so that the watchdog acts soon after the shot, and before the memory's end.

    recorded: samples of the whole recording.  Raises SequenceRejected if the memory or the counter is too short.
    A board that plays nothing has nothing in its memory.
    """
    over = max(recorded, *(p.samples for p in programs))
    late = over + round(LATE_S * rate_hz)
    last = min((WRITTEN_STEPS * p.step_samples for p in programs if not p.silent), default=late)
    step = min(late, last) // STEPS
    if STEPS * step < over + LEAST_LATE_S * rate_hz:
        raise _too_long(f"the card writes {WRITTEN_STEPS} steps of its memory, {last / rate_hz:.3g} s", over / rate_hz)
    if step * decimation >= COUNTER_CLOCKS:
        raise _too_long("its counter is too short for that", over / rate_hz)
    return step


def longest_shot(step_samples: int, rate_hz: float) -> int:
    """Samples that a recording may have at most, whose edges lie on the coarsest grid that is used."""
    coarsest = step_samples * max(1, LONGEST_STEP // step_samples)
    return WRITTEN_STEPS * coarsest - round(LEAST_LATE_S * rate_hz)


def armed(step_samples: int) -> list[str]:
    """Questions, and a pulse on the wire with the trigger off: it presses the input and lets go of it.

    step_samples: of the sequence; 0: there is none, and it is not asked for.
    """
    header = pin_header(WIRE_PIN)
    pulse = [f"{header} ON", f"{header}?", EMERGENCY_PIN, f"{header} OFF", f"{header}?", EMERGENCY_PIN]
    steps = ["RP:DAC:SEQ:SAMPLESPERSTEP?"] if step_samples else []
    return [*steps, "RP:COUNTER:SAMPLESPERSTEP?", "RP:INSTANTRESET:MODE?", EMERGENCY_PIN, *pulse]


def check_armed(answers: Sequence[Value], step_samples: int, counter: int, where: str) -> None:
    """The answers to `armed`, of which step_samples 0 does not ask for the step of the sequence.

    Raises DeviceProtocolError if the card has lost what it was told, DeviceFault if the wire is missing, or if
    something holds the emergency input.
    """
    told = [step_samples, counter, "ON"] if step_samples else [counter, "ON"]
    found, (held, _, high, pressed, _, low, released) = list(answers[: len(told)]), answers[len(told) :]
    if found != told:
        raise DeviceProtocolError(
            "the card has lost the watchdog of its memory",
            where=where,
            why=f"told {told}, it reads back {found}: its server was restarted, or another client was there",
            remedy="stop the card, which loads it anew",
        )
    if held or released:
        raise DeviceFault(
            "the emergency input keeps the outputs off",
            where=where,
            why=f"DIO3_P is high {'before' if held else 'after'} the watchdog's wire was raised",
            remedy="find out why DIO3_P of the card is high",
        )
    if (high, low) != ("ON", "OFF"):
        raise DeviceFault(
            f"{WIRE_PIN} does not follow: it reads back {high} and {low}, told ON and OFF",
            where=where,
            why="something else drives that pin",
            remedy=REMEDY,
        )
    if not pressed:
        raise wire_missing(where, f"DIO3_P stays low while {WIRE_PIN} is high: no wire, or one to another pin")


def wire_missing(where: str, why: str) -> DeviceFault:
    """Without the wire nothing ends a shot that plays again and again when this computer is gone."""
    return DeviceFault(MISSING, where=where, why=why, remedy=REMEDY)


def followers(ask: Ask) -> list[str]:
    """Other pins that are high when DIO4_N is, and only then: where its wire may go instead."""
    others = [pin for pin in DIGITAL_PINS if pin != WIRE_PIN]
    questions = [f"{pin_header(pin)}?" for pin in others]
    header = pin_header(WIRE_PIN)
    answers = ask(*questions, f"{header} ON", f"{header}?", *questions, f"{header} OFF")
    before, during = answers[: len(others)], answers[len(others) + 2 : -1]
    return [pin for pin, a, b in zip(others, before, during, strict=True) if (a, b) == ("OFF", "ON")]


def lost_in_the_end(where: str) -> DeviceError:
    """The error for a trigger that falls and leaves the emergency input latched."""
    return DeviceFault(
        "the emergency input stays latched though the trigger is off", where=where, remedy="restart the card"
    )


def _too_long(why: str, length_s: float) -> SequenceRejected:
    return SequenceRejected(
        f"a shot of {length_s:.3g} s cannot stay in the card's memory",
        where="io_card.replay_watchdog",
        why=why,
        remedy="put its edges on a coarser grid, make it shorter, or set io_card.replay_watchdog = false",
    )
