"""The back end `serial`: Tx/Rx switch and LNA on serial lines."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

from drivers.backend import RealBackend
from drivers.exchange import Exchange, closed_on_error
from drivers.serial_line.lna import SerialLna
from drivers.serial_line.switch import SerialSwitch
from drivers.serial_line.wire import SerialWire
from drivers.validation import validated

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class Section(BaseModel):
    """Unknown keys are errors, nothing is coerced."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class LineTable(Section):
    """A device on a serial line: port, baud rate, text that its `*IDN?` must contain, and how long to wait, s."""

    port: Annotated[str, Field(min_length=1)]
    baud: Annotated[int, Field(ge=300)] = 115200
    identity: str = ""
    timeout_s: Positive = 1.0


class LnaTable(LineTable):
    """`[lna]`: gain V/V set at the start."""

    gain: Positive


class SerialBackend(RealBackend):
    """See drivers.platform.Backend; the table `[backends.serial]` is empty."""

    name = "serial"

    def __init__(self, options: Mapping[str, Any]) -> None:
        validated(Section, options, "backends.serial")

    def tx_rx_switch(self, options: Mapping[str, Any]) -> SerialSwitch:
        """See Backend."""
        table = validated(LineTable, options, "tx_rx_switch")
        exchange = Exchange(
            f"tx_rx_switch {table.port}", lambda: _wire(table), table.identity, on_open=SerialSwitch.prepare
        )
        with closed_on_error(exchange):
            return SerialSwitch(exchange)

    def lna(self, options: Mapping[str, Any]) -> SerialLna:
        """See Backend."""
        table = validated(LnaTable, options, "lna")
        exchange = Exchange(f"lna {table.port}", lambda: _wire(table), table.identity)
        with closed_on_error(exchange):
            return SerialLna(exchange, table.gain)


def _wire(table: LineTable) -> SerialWire:
    return SerialWire(table.port, table.baud, table.timeout_s)
