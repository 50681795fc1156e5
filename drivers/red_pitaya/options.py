"""Tables of the back end `red_pitaya`.  Keys are required unless they have a default."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from drivers.errors import ConfigError
from drivers.red_pitaya.layout import ANALOG_PINS, DIGITAL_PINS, BoardLayout, Layout, LinePin
from drivers.timeline import DigitalLine, SampleClock
from drivers.validation import validated

BASE_FREQUENCY_HZ = 125e6
SAFE_STEPS_PER_S = 12e3  # the server's thread keeps up with so many
LONGEST_MOVE_S = 1.0  # of a Tx/Rx switch
LONGEST_PIN_DELAY_S = 0.5  # a gate that is set by command is lowered 0.25 s later at the latest, so within 1 s

REMOVED_OPTION = "replay_watchdog"

Port = Annotated[int, Field(ge=1, le=65535)]
Channel = Annotated[int, Field(ge=0, le=1)]
Channels = Annotated[tuple[Channel, ...], Field(strict=False, max_length=2)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class Section(BaseModel):
    """Unknown keys are errors, nothing is coerced."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class BoardTable(Section):
    """One card: its address, and which of its inputs (0: IN1, 1: IN2) and outputs are used, in order."""

    host: Annotated[str, Field(min_length=1)]
    command_port: Port = 5025
    data_port: Port = 5026
    inputs: Channels = (0, 1)
    outputs: Channels = (0, 1)

    @model_validator(mode="after")
    def _each_once(self) -> Self:
        if len(set(self.inputs)) < len(self.inputs) or len(set(self.outputs)) < len(self.outputs):
            raise ValueError("an input or output is named twice")
        return self


class LineTable(Section):
    """A digital line: index of the card, and its pin: AO0..AO3 (sample-timed, 0 or 1.8 V) or a DIO pin (ms-timed)."""

    board: Annotated[int, Field(ge=0)] = 0
    pin: str


class LinesTable(Section):
    """Pins of the two lines."""

    pa_gate: LineTable = LineTable(pin="AO0")
    rx_connect: LineTable = LineTable(pin="AO1")


class CardTable(Section):
    """`[io_card]`: the cards, the first of which is the master, and how to run them.

    step_samples: grid of all edges of a sequence; chunk_samples: samples per status record, which is also how long the
    card takes no command while it sends; server_version, image_version (None: the same number): what the VERsion
    queries must answer; reply_timeout_s, sample_timeout_s: how long to wait, in a shot less (`limit_reply_times` in
    boards.py); require_calibration: refuse a card whose inputs were never calibrated; pin_delay_s: how late a DIO line
    may be set, and 0.25 s after that the driver's own timer lowers a gate whose end no sample has reported;
    instant_reset: the card's input DIO3_P may switch the outputs off; prove_wiring: at the start the master triggers
    all boards with nothing to play, and a line on AO1 to AO3 moves the switch.
    """

    boards: Annotated[tuple[BoardTable, ...], Field(strict=False, min_length=1)]
    lines: LinesTable = LinesTable()
    decimation: Annotated[int, Field(ge=8, le=8192, multiple_of=2)] = 2048
    step_samples: Annotated[int, Field(ge=1, le=65536)] = 16
    chunk_samples: Annotated[int, Field(ge=32, le=6103)] = 608
    server_version: Annotated[int, Field(ge=1)] = 11
    image_version: Annotated[int, Field(ge=0)] | None = None
    reply_timeout_s: Positive = 5.0
    sample_timeout_s: Positive = 5.0
    require_calibration: bool = False
    pin_delay_s: Annotated[float, Field(gt=0, le=LONGEST_PIN_DELAY_S)] = 0.06
    instant_reset: bool = True
    trigger: Literal["internal", "external"] = "internal"
    prove_wiring: bool = True

    @model_validator(mode="after")
    def _fits(self) -> Self:
        rate_hz = BASE_FREQUENCY_HZ / self.decimation
        if rate_hz / self.step_samples > SAFE_STEPS_PER_S:
            raise ValueError(f"step_samples must be at least {rate_hz / SAFE_STEPS_PER_S:.1f}, or steps get lost")
        if self.chunk_samples / rate_hz > 0.1:
            raise ValueError("chunk_samples must not exceed 0.1 s: commands wait for the end of a chunk")
        addresses = [(b.host, b.command_port) for b in self.boards]
        if len(set(addresses)) < len(addresses):
            raise ValueError("two boards have the same address")
        return self

    def layout(self) -> Layout:
        """The terminals of all boards and their use.  Raises ConfigError for a pin or board that does not exist."""
        tables = {DigitalLine.PA_GATE: self.lines.pa_gate, DigitalLine.RX_CONNECT: self.lines.rx_connect}
        for line, table in tables.items():
            check_pin(table.board, table.pin, len(self.boards), f"io_card.lines.{line.value}")
        _check_timing([t.pin for t in tables.values()])
        pins = [(t.board, t.pin) for t in tables.values()]
        if len(set(pins)) < len(pins):
            raise ConfigError("both lines are on the same pin", where="io_card.lines", remedy="give each its own")
        return Layout(
            boards=tuple(BoardLayout(b.inputs, b.outputs) for b in self.boards),
            lines={line: LinePin(t.board, t.pin) for line, t in tables.items()},
            clock=SampleClock(BASE_FREQUENCY_HZ, self.decimation),
            step_samples=self.step_samples,
            pin_delay_s=self.pin_delay_s,
        )

    @model_validator(mode="after")
    def _has_terminals(self) -> Self:
        for key in ("inputs", "outputs"):
            if not any(getattr(board, key) for board in self.boards):
                raise ValueError(f"no board has {key}")
        return self

    @model_validator(mode="after")
    def _lines_can_be_driven(self) -> Self:
        for name, line in (("pa_gate", self.lines.pa_gate), ("rx_connect", self.lines.rx_connect)):
            if line.pin == "AO3":
                raise ValueError(
                    f"lines.{name}: a server that loses its client zeroes the other outputs and forgets AO3"
                )
        if self.lines.pa_gate.board != 0 and self.lines.pa_gate.pin in ANALOG_PINS:
            raise ValueError(
                "lines.pa_gate: timed by a board's sequence, it must be on the master, board 0: a slave's trigger "
                "comes over a cable, and one that is loose plays what is in the slave's memory again"
            )
        if self.prove_wiring and self.lines.pa_gate.pin in ANALOG_PINS[1:]:
            raise ValueError(
                "lines.pa_gate: nothing reads the gate back, and images of server 0.11.1 drive AO0 only; put it on "
                "AO0, or set prove_wiring = false if you have seen it move"
            )
        return self


def _check_timing(pins: list[str]) -> None:
    """Raises ConfigError if one line is timed by the card and the other by the host."""
    if len({pin in ANALOG_PINS for pin in pins}) > 1:
        raise ConfigError(
            "the amplifier's gate and the receiver are timed by different clocks",
            where="io_card.lines",
            why=f"gate on {pins[0]}, receiver on {pins[1]}: one follows the card's sequence, the other a command of "
            "this computer, and when this computer is late the receiver is connected to the live amplifier",
            remedy="put both on AO0 ... AO2 (timed by the card), or both on DIO pins (timed by the host)",
        )


class SwitchTable(Section):
    """`[tx_rx_switch]` driven by the card's line: its times s, and the DIO pin that reads its contacts back, high on
    RECEIVE.  no_readback: there is none, and the position is what the line says, after the switch's time."""

    dead_time_s: Positive
    bounce_s: Annotated[float, Field(ge=0, allow_inf_nan=False)]
    settle_s: Annotated[float, Field(ge=0, allow_inf_nan=False)]
    readback: LineTable | None = None
    no_readback: bool = False

    @model_validator(mode="after")
    def _declared(self) -> Self:
        if (self.readback is None) is not self.no_readback:
            raise ValueError(
                "name the pin that reads the contacts back (readback), or declare that there is none "
                "(no_readback = true): a stuck relay then goes unnoticed, and every recording says so"
            )
        if not self.dead_time_s + self.bounce_s + self.settle_s < LONGEST_MOVE_S:
            raise ValueError(
                f"dead_time_s, bounce_s and settle_s together must be less than {LONGEST_MOVE_S} s: they pass "
                "each time that outputs are switched off"
            )
        return self


class AmplifierTable(Section):
    """`[power_amplifier]` enabled by a DIO pin, and the pin on which it reports a fault, low when healthy (absent: it
    cannot report one)."""

    enable: LineTable
    fault: LineTable | None = None


def check_pin(board: int, pin: str, boards: int, where: str, *, digital: bool = False) -> None:
    """Raises ConfigError for a pin or a board that does not exist."""
    pins = DIGITAL_PINS if digital else (*ANALOG_PINS, *DIGITAL_PINS)
    if pin not in pins:
        raise ConfigError(f"the card has no pin {pin!r}", where=where, remedy=f"use one of {', '.join(pins)}")
    if board >= boards:
        raise ConfigError(f"there is no board {board}", where=where, remedy=f"boards are 0 to {boards - 1}")


def card_table(options: Mapping[str, Any]) -> CardTable:
    """`[io_card]` checked.  Raises ConfigError, also for an option that earlier versions had."""
    if REMOVED_OPTION in options:
        raise ConfigError(
            f"key '{REMOVED_OPTION}' is unknown (value {options[REMOVED_OPTION]!r})",
            where="io_card",
            why="the option was removed: every shot is uploaded to the cards, and none is played from their memories",
            remedy=f"remove io_card.{REMOVED_OPTION} from the platform file, and the wire from DIO4_N to DIO3_P",
        )
    return validated(CardTable, options, "io_card")
