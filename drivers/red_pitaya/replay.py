"""A board whose memory keeps a shot, to be played again without an upload: `io_card.replay_watchdog`.

`SEQ:SAMPLESPERSTEP`, told again after `SEQ:SET`, takes the server's hand off the sequence (scpi_commands.c sets
seqState to CONFIG; the control thread looks after a prepared or running one only), and leaves memory and amplitudes as
they are.  Each trigger then plays the same shot, and its fall ends it at once, with nothing to clean up.  What is left
is a ring of 8192 steps that plays for as long as the trigger is on: the watchdog ends that (watchdog.py).

Only a new connection empties the memory (stopTx); with a shot in it the trigger must be off, and is read back.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from drivers.errors import ConfigError, DeviceError, DeviceProtocolError, PlatformError, ShotRefused
from drivers.red_pitaya.board import Board
from drivers.red_pitaya.commands import ENDED, RUNNING, SENDING, TRIGGERED
from drivers.red_pitaya.emergency import EMERGENCY_PIN, emergency_stop
from drivers.red_pitaya.layout import pin_header
from drivers.red_pitaya.sequence import BoardProgram, Sine
from drivers.red_pitaya.silence import OUTPUTS_OFF, QUIET_V, READ_BACK
from drivers.red_pitaya.sines import arming, check_amplitudes
from drivers.red_pitaya.stream import Continuity, Record
from drivers.red_pitaya.watchdog import COUNTER_PINS, STEPS, WIRE_PIN, armed, check_armed, counter_step

GRANULE = 32  # the write pointer goes in steps of so many samples


@dataclass
class ReplayBoard(Board):
    """See the module.

    counter_step: samples per step of its watchdog; rested: all sines were switched off since the last shot.
    """

    after_shot = ()
    counter_step: int = field(init=False, default=0)
    rested: bool = field(init=False, default=False)
    _held: BoardProgram | None = field(init=False, default=None)
    _held_step: int = field(init=False, default=0)
    _told: tuple[Sine, ...] | None = field(init=False, default=None)
    _armed_v: list[float] = field(init=False, default_factory=list)

    def settle(self) -> None:
        """See Board.  The new connection has emptied the memory."""
        self._held = self._told = None
        super().settle()

    def use_pin(self, pin: str, *, output: bool) -> None:
        """See Board.  Raises ConfigError for the pins that the watchdog needs."""
        if pin == WIRE_PIN or (output and pin in COUNTER_PINS):
            raise ConfigError(
                f"the pin {pin} cannot be used with io_card.replay_watchdog",
                where=self.where,
                why="the watchdog's wire begins at DIO4_N, and its counter pulses on DIO2_N and DIO3_N, too",
                remedy="take another pin (DIO2_N and DIO3_N still serve as inputs)",
            )
        super().use_pin(pin, output=output)

    def _configure(self) -> None:
        """See Board.  The wire is driven low; the counter's other bits shall reach nobody."""
        super()._configure()
        header = pin_header(WIRE_PIN)
        unused = [pin for pin in COUNTER_PINS if pin not in self.input_pins]
        self.ask(f"{header} OFF", f"{header}:HBRIDGE OFF", f"{header}:DIR OUT",
                 *(f"{pin_header(pin)}:DIR IN" for pin in unused))  # fmt: skip

    def holds(self, program: BoardProgram) -> bool:
        """Whether this shot is in the memory, with its watchdog; the sines are told anew each time."""
        old = self._held
        if old is None or self._held_step != self.counter_step or old.silent != program.silent:
            return False
        return old.silent or old.same_steps(program)

    @property
    def occupied(self) -> bool:
        """A shot is in the memory."""
        return self._held is not None

    @property
    def stale(self) -> bool:
        """A shot is in the memory, and since it was played it was stopped already: it has waited long enough."""
        return self.occupied and self.rested

    def load(self, program: BoardProgram) -> None:
        """See Board.  Nothing is sent if the memory has it."""
        if not self.holds(program):
            super().load(program)

    def arm(self, program: BoardProgram) -> None:
        """See Board.  The memory is written only if it does not hold this shot; wire and watchdog are proved each
        time, before power: errors as in `check_armed`."""
        if not self.holds(program):
            self._fill(program)
        scales = [self.scale.output[s.output] for s in program.sines]
        waves, amplitudes, self._sounding = arming(program.sines, scales)
        if self._told != program.sines:
            sines = [*OUTPUTS_OFF, *waves, *amplitudes]
        else:  # as the shot before, and off only if it was stopped since; what there is reads back in any case
            sines = amplitudes if self.rested else []
        self.rested, self._told = False, program.sines
        step = 0 if program.silent else program.step_samples
        wire = armed(step)
        answers = self.ask(*wire, *sines, *READ_BACK)
        check_armed(answers[: len(wire)], step, self.counter_step, self.where)
        found = dict(zip(READ_BACK, (float(v) for v in answers[-len(READ_BACK) :]), strict=True))
        self._armed_v = [found.pop(question) for question in self._sounding]
        check_amplitudes(program.sines, scales, self._armed_v, self.where)
        if any(abs(volts) > QUIET_V for volts in found.values()):
            raise DeviceProtocolError(
                "an output that shall be silent is not", where=self.where, why=f"read back: {found}",
                remedy="stop the card, which connects anew",
            )  # fmt: skip

    def _fill(self, program: BoardProgram) -> None:
        """The sequence into the memory, and the server's hand off it.

        Raises DeviceError if the memory is not empty: a second SEQ:SET would leave the old one there, all gates open.
        """
        if self.occupied:
            raise DeviceError("the memory holds another shot", where=self.where, remedy="stop the card, then repeat it")
        self._held = program  # at least in part, from here on
        self._held_step = 0
        step = f"RP:DAC:SEQ:SAMPLESPERSTEP {program.step_samples}"
        sequence = [] if program.silent else ["RP:DAC:SEQ:SET", step]
        commands = [*sequence, f"RP:COUNTER:SAMPLESPERSTEP {self.counter_step}", "RP:MODE ACQUISITION"]
        emergency, *_ = self.ask(EMERGENCY_PIN, *commands)
        if emergency:
            raise emergency_stop(self.where, "the emergency input keeps the outputs off")
        self._held_step = self.counter_step

    def account(self, program: BoardProgram, start_samples: int) -> Continuity:
        """See Board.  The server does not know that anything plays."""
        return Unattended(self.where, 0)

    def play(self) -> tuple[bool, bool]:
        """See Board.  The recording is over: the shot was whole if trigger and amplitudes are as they were.

        Nobody but a client's end takes them away: there is no clean-up.  Raises what `stopped` returns, and ShotRefused
        if they are not.
        """
        status, latched, written, mode, *volts = self.ask(*ENDED, *self._sounding)
        self.written = int(written)
        if latched:
            raise self.stopped()
        if [float(v) for v in volts] != self._armed_v or int(status) & (TRIGGERED | RUNNING) != TRIGGERED:
            raise ShotRefused(
                "the outputs ended early",
                where=self.where,
                why=f"the server's status is {status}, amplitudes are {volts} V and were {self._armed_v} V",
            )
        return mode == SENDING, False

    def stopped(self) -> PlatformError:
        """See Board.  When the watchdog's time has come, it may have been that."""
        if int(self.ask("RP:ADC:WP?")[0]) < STEPS * self.counter_step - GRANULE:
            return emergency_stop(self.where)
        return ShotRefused(
            "this computer was too late for the end of the shot",
            where=self.where,
            why="the card's watchdog has ended it, or else its emergency input did: the card cannot tell which",
        )

    def quiet(self) -> None:
        """See Board.  With a shot in the memory also the trigger is read back, which alone keeps it from being played.

        Raises DeviceError if it is on.
        """
        if not self.occupied:
            super().quiet()
            return
        self.rested = True
        self.switch_off()
        level, status = self.ask("RP:TRIGGER?", "RP:STATUS?")
        if level != "OFF" or int(status) & (TRIGGERED | RUNNING):
            raise DeviceError("the trigger is on", where=self.where, remedy="stop the card, which connects anew")


class Unattended(Continuity):
    """The account of a shot that the server does not know of."""

    def _check_playing(self, record: Record) -> None:
        """Raises ShotRefused if the server looks after a sequence all the same: it would clean up, and forget it."""
        if record.playing:
            raise ShotRefused("the server plays a sequence of its own", where=self._where)


def room_is_needed(boards: Sequence[Board], programs: Sequence[BoardProgram], recorded: int, rate_hz: float) -> bool:
    """Tell boards with a watchdog when it shall act; whether memories hold another shot, which a new connection must
    empty before this one can be written.

    recorded: samples of the whole recording.  Raises SequenceRejected as `counter_step` does.
    """
    mine = [(board, p) for board, p in zip(boards, programs, strict=True) if isinstance(board, ReplayBoard)]
    if not mine:
        return False
    step = counter_step(programs, recorded, rate_hz, mine[0][0].table.decimation)
    for board, _ in mine:
        board.counter_step = step
    return any(board.occupied for board, _ in mine) and not all(board.holds(program) for board, program in mine)


def stale(boards: Sequence[Board]) -> bool:
    """A memory holds a shot that has waited long enough: a stop shall empty it."""
    return any(isinstance(board, ReplayBoard) and board.stale for board in boards)
