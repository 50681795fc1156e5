"""Tables of the back end `scpi`: how to reach a device, and what it calls things."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Port = Annotated[int, Field(ge=1, le=65535)]
Word = Annotated[str, Field(min_length=1)]
UsbId = Annotated[int, Field(ge=0, le=0xFFFF)]


class Section(BaseModel):
    """Unknown keys are errors, nothing is coerced."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class SocketTable(Section):
    """Where an emulated USB device listens; with real hardware there is no such table."""

    host: Word
    port: Port


class DeviceTable(Section):
    """How to reach a device.

    transport usb: vendor_id, product_id and, if there are several, serial, or the socket of an emulated one; serial:
    port (a path) and baud; tcp: host and tcp_port.  line_end: of both directions, not for usb.  identity: text that its
    identification must contain; timeout_s: how long to wait for an answer.
    """

    transport: Literal["usb", "serial", "tcp"]
    vendor_id: UsbId | None = None
    product_id: UsbId | None = None
    serial: str | None = None
    socket: SocketTable | None = None
    port: Word | None = None
    baud: Annotated[int, Field(ge=300)] = 115200
    host: Word | None = None
    tcp_port: Port = 5025
    line_end: Literal["\n", "\r\n", "\r"] = "\n"
    identity: str = ""
    timeout_s: Positive = 2.0

    @model_validator(mode="after")
    def _reachable(self) -> Self:
        needs = {"usb": ("vendor_id", "product_id"), "serial": ("port",), "tcp": ("host",)}[self.transport]
        missing = [name for name in needs if getattr(self, name) is None]
        if missing:
            raise ValueError(f"transport {self.transport!r} needs {' and '.join(missing)}")
        return self


class Words(Section):
    """Answers that mean yes and no, and answers to `fault` that mean none (empty: it answers by number); case does not
    matter."""

    yes: Annotated[tuple[Word, ...], Field(strict=False)] = ("1", "ON")
    no: Annotated[tuple[Word, ...], Field(strict=False)] = ("0", "OFF")
    healthy: Annotated[tuple[Word, ...], Field(strict=False)] = ()


class AmplifierCommands(Section):
    """Texts of a power amplifier; empty: it has no such command.

    fault must answer a number, 0 when healthy, and perhaps a text after a comma, or one of `words.healthy`; error a
    number and a text.
    """

    identify: Word = "*IDN?"
    clear: str = "*CLS"
    error: str = "SYST:ERR?"
    enable: Word = "OUTP ON"
    disable: Word = "OUTP OFF"
    enabled: Word = "OUTP?"
    mute: str = "OUTP:MUTE ON"
    unmute: str = "OUTP:MUTE OFF"
    muted: str = "OUTP:MUTE?"
    temperature: str = "SYST:TEMP?"
    fault: str = "STAT:FAULT?"
    reset_fault: str = "STAT:FAULT:RES"
    clipped: str = "STAT:CLIP?"

    @model_validator(mode="after")
    def _mutes_or_not(self) -> Self:
        if len({bool(self.mute), bool(self.unmute), bool(self.muted)}) > 1:
            raise ValueError("mute, unmute and muted go together: give all three or leave all three empty")
        return self


class AmplifierTable(DeviceTable):
    """`[power_amplifier]`."""

    commands: AmplifierCommands = AmplifierCommands()
    words: Words = Words()


class LnaCommands(Section):
    """Texts of an LNA; `{gain}` is replaced by the gain in V/V; overload and clear_overload may be empty."""

    identify: Word = "*IDN?"
    gain: Word = "GAIN?"
    set_gain: Word = "GAIN {gain}"
    overload: str = "OVL?"
    clear_overload: str = "OVL:CLR"


class LnaTable(DeviceTable):
    """`[lna]`: the gains it has, rising, and the one to set, V/V."""

    gains: Annotated[tuple[Positive, ...], Field(strict=False, min_length=1)]
    gain: Positive
    commands: LnaCommands = LnaCommands()
    words: Words = Words()


class ThermometerCommands(Section):
    """Texts of a thermometer that answers in deg C."""

    identify: Word = "*IDN?"
    temperature: Word = "MEAS:TEMP?"


class ThermometerTable(DeviceTable):
    """`[thermometer]`."""

    commands: ThermometerCommands = ThermometerCommands()
