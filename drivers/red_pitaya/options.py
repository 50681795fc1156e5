"""Tables of the back end `red_pitaya`.  Keys are required unless a default stands here."""

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
    """`[io_card]`: the cards, the first being the master, and how to run them.

    step_samples: grid of all edges of a sequence; chunk_samples: samples per status record and the time until the card
    looks at commands while it sends; server_version and image_version (None: the same number): what VERsion queries
    must answer; reply_timeout_s and sample_timeout_s: how long to wait; require_calibration: refuse a card whose
    inputs were never calibrated; pin_delay_s: how late a DIO line may be set; instant_reset: let the card's input
    DIO3_P switch the outputs off.
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
    pin_delay_s: Positive = 0.06
    instant_reset: bool = True
    trigger: Literal["internal", "external"] = "internal"

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
        """Who is what on which board.  Raises ConfigError for a pin or board that does not exist."""
        tables = {DigitalLine.PA_GATE: self.lines.pa_gate, DigitalLine.RX_CONNECT: self.lines.rx_connect}
        for line, table in tables.items():
            check_pin(table.board, table.pin, len(self.boards), f"io_card.lines.{line.value}")
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


class SwitchTable(Section):
    """`[tx_rx_switch]` driven by the card's line: its times s, and the DIO pin that reads its contacts back, high on
    RECEIVE (absent: the position is what the line says, after the switch's time)."""

    dead_time_s: Positive
    bounce_s: Annotated[float, Field(ge=0, allow_inf_nan=False)]
    settle_s: Annotated[float, Field(ge=0, allow_inf_nan=False)]
    readback: LineTable | None = None


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
    """`[io_card]` checked.  Raises ConfigError."""
    return validated(CardTable, options, "io_card")
