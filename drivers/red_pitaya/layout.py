"""Which input, output and line of the platform is which terminal of which board."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from drivers.timeline import DigitalLine, SampleClock

ANALOG_PINS = ("AO0", "AO1", "AO2", "AO3")
DIGITAL_PINS = ("DIO7_P", "DIO7_N", "DIO6_P", "DIO6_N", "DIO5_N", "DIO4_N", "DIO3_N", "DIO2_N")
FIRST_ANALOG_CHANNEL = 2  # of a sequence: 0 and 1 are OUT1 and OUT2


@dataclass(frozen=True)
class BoardLayout:
    """Used inputs and outputs of a board, each 0 or 1, in the order in which the platform counts them."""

    inputs: tuple[int, ...]
    outputs: tuple[int, ...]


@dataclass(frozen=True)
class LinePin:
    """A line's board and pin."""

    board: int
    pin: str

    @property
    def sequence_channel(self) -> int | None:
        """Channel of the sequence for an analog pin, None for a DIO pin."""
        return FIRST_ANALOG_CHANNEL + ANALOG_PINS.index(self.pin) if self.pin in ANALOG_PINS else None


@dataclass(frozen=True)
class Layout:
    """All boards, the master first, the lines, the sample clock, the grid of edges and the delay of DIO lines."""

    boards: tuple[BoardLayout, ...]
    lines: Mapping[DigitalLine, LinePin]
    clock: SampleClock
    step_samples: int
    pin_delay_s: float

    @property
    def inputs(self) -> int:
        """Inputs of all boards together."""
        return sum(len(b.inputs) for b in self.boards)

    @property
    def outputs(self) -> int:
        """Outputs of all boards together."""
        return sum(len(b.outputs) for b in self.boards)

    def output(self, index: int) -> tuple[int, int]:
        """Board and output on it of the platform's output `index`."""
        return [(b, out) for b, board in enumerate(self.boards) for out in board.outputs][index]

    def unproved_lines(self) -> tuple[DigitalLine, ...]:
        """Lines on AO1 to AO3: released images with the same version number leave these off."""
        return tuple(line for line, pin in self.lines.items() if pin.pin in ANALOG_PINS[1:])

    def line_delay_s(self) -> float:
        """How late a line may be set: nothing for sample-timed pins."""
        return max(0.0 if pin.sequence_channel is not None else self.pin_delay_s for pin in self.lines.values())


def pin_header(pin: str) -> str:
    """Command header of a DIO pin: `DIO7_P` -> `RP:DIO:PIN7:SIDEP`."""
    return f"RP:DIO:PIN{pin[3]}:SIDE{pin[5]}"
