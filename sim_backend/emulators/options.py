"""Options of an emulator: its TOML file, of which `io_card/options.py` has the cards.

config/emulators/lab.toml is the commented original.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from sim_backend.options import DipoleTable
from sim_backend.section import Positive, Section

from .io_card.options import CardsOptions, Name, Port
from .wire_faults import WireFault


class SerialOptions(Section):
    """A device on a pseudo-terminal; link: a path that shall lead to it (None: the emulator makes one up)."""

    kind: Literal["switch", "lna"]
    link: str | None = None
    serial: Name = "S1"


class AmplifierOptions(Section):
    """`usb`: the class-D amplifier as a USBTMC device; `line`: always on, the gate line alone decides."""

    kind: Literal["usb", "line"] = "usb"
    port: Port = 0
    vendor_id: Annotated[int, Field(ge=0, le=0xFFFF)] = 0x1209
    product_id: Annotated[int, Field(ge=0, le=0xFFFF)] = 0x0D0D
    serial: Name = "A1"


class EmulatorOptions(Section):
    """The whole file.  platform: a platform file whose table `[backends.simulated]` is the world; [world] changes keys
    of it (or is all of it); specimen: a resonator file;
    reference_dipole: as in a platform file, put in by the control socket; speed: world seconds per second."""

    host: Name = "127.0.0.1"
    seed: Annotated[int, Field(ge=0)] = 1
    speed: Positive = 1.0
    platform: str | None = None
    specimen: str | None = None
    world: dict[str, Any] = Field(default_factory=dict)
    control_port: Port = 0
    reference_dipole: DipoleTable | None = None
    lna_gain: Positive | None = None
    io_cards: CardsOptions
    amplifier: AmplifierOptions = AmplifierOptions()
    serial: dict[str, SerialOptions] = Field(default_factory=dict)
    wire_faults: Annotated[tuple[WireFault, ...], Field(strict=False)] = ()
