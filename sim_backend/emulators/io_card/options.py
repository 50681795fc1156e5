"""Options of the emulated I/O cards: the table `[io_cards]` of an emulator's file."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from sim_backend.section import Finite, Positive, Section

from .registers import PINS

Port = Annotated[int, Field(ge=0, le=65535)]
Axis = Literal["x", "y", "z", ""]
Terminal = Literal["x", "y", "z", "dipole", ""]
Pair = Annotated[tuple[Axis, Axis], Field(strict=False)]
Terminals = Annotated[tuple[Terminal, Terminal], Field(strict=False)]
Name = Annotated[str, Field(min_length=1)]
Two = Annotated[tuple[Positive, Positive], Field(strict=False)]
TwoOffsets = Annotated[tuple[Finite, Finite], Field(strict=False)]
AXES = ("x", "y", "z")
OUTPUTS = (*AXES, "dipole")  # as the world counts them
NOMINAL_SCALE = 1 / 32768


class BoardOptions(Section):
    """One card.

    command_port, data_port: 0: any free one; inputs, outputs: the axis of each ("": nothing connected; an output may
    also feed the "dipole"); slow_outputs: how many of AO0 ... AO3 its image drives (1: that of server 0.11.1);
    ending_s: how long the server takes to end a client that has disconnected; memory_access_s: for one access to its
    sequence memory; server_version, image_version: what it reports; adc_scale_v (V per code), dac_scale (register per
    V), adc_offset_v, calibration_flags: its EEPROM, which the converters match exactly.
    """

    command_port: Port = 0
    data_port: Port = 0
    inputs: Pair
    outputs: Terminals
    slow_outputs: Annotated[int, Field(ge=1, le=4)] = 4
    ending_s: Annotated[float, Field(ge=0, allow_inf_nan=False)] = 0.05
    memory_access_s: Annotated[float, Field(ge=0, le=1e-5, allow_inf_nan=False)] = 250e-9
    server_version: Annotated[int, Field(ge=0)] = 11
    image_version: Annotated[int, Field(ge=0)] = 11
    adc_scale_v: Two = (NOMINAL_SCALE, NOMINAL_SCALE)
    adc_offset_v: TwoOffsets = (0.0, 0.0)
    dac_scale: Two = (1.0, 1.0)
    calibration_flags: Annotated[int, Field(ge=0, lt=4096)] = 0b1111


class LineOptions(Section):
    """Where a digital line of the world is wired: board and `AO0` ... `AO3` or a pin like `DIO7_P`."""

    board: Annotated[int, Field(ge=0)] = 0
    output: Name

    @model_validator(mode="after")
    def _exists(self) -> Self:
        if self.pdm() is None and self.pin() is None:
            raise ValueError(f"output {self.output!r} is neither AO0 ... AO3 nor one of the usable pins")
        return self

    def pdm(self) -> int | None:
        """Number of the slow analogue output, None: it is a pin."""
        return int(self.output[2]) if self.output in ("AO0", "AO1", "AO2", "AO3") else None

    def pin(self) -> str | None:
        """Name of the pin as in `registers.PINS`, None: it is an analogue output."""
        name = self.output.removeprefix("DIO").replace("_", "")
        return name if name in PINS and self.output == f"DIO{name[0]}_{name[1]}" else None


class CardsOptions(Section):
    """The cards: the first is the master.  trigger_wire: `sata` cable or `dio` (master DIO5_P to DIO0_P of all)."""

    boards: Annotated[tuple[BoardOptions, ...], Field(strict=False, min_length=1)]
    pa_gate: LineOptions = LineOptions(output="AO0")
    rx_connect: LineOptions = LineOptions(output="AO1")
    trigger_wire: Literal["sata", "dio"] = "sata"

    @model_validator(mode="after")
    def _boards_exist(self) -> Self:
        for line in (self.pa_gate, self.rx_connect):
            if line.board >= len(self.boards):
                raise ValueError(f"there is no board {line.board}")
        return self
