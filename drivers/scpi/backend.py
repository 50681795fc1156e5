"""The back end `scpi`: power amplifier, LNA and thermometer, each described by its table alone."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from drivers.backend import RealBackend
from drivers.errors import ConfigError
from drivers.exchange import Exchange, closed_on_error
from drivers.scpi.amplifier import ScpiAmplifier
from drivers.scpi.dialogue import number
from drivers.scpi.lna import ScpiLna
from drivers.scpi.options import AmplifierTable, DeviceTable, LnaTable, Section, ThermometerTable
from drivers.scpi.wires import open_wire
from drivers.validation import validated


class ScpiThermometer:
    """See drivers.thermometer.Thermometer."""

    def __init__(self, exchange: Exchange, question: str) -> None:
        self._exchange = exchange
        self._question = question

    def temperature_c(self) -> float:
        """See Thermometer."""
        return number(self._exchange, self._question)

    def close(self) -> None:
        """See Thermometer."""
        self._exchange.close()


class ScpiBackend(RealBackend):
    """See drivers.platform.Backend; the table `[backends.scpi]` is empty."""

    name = "scpi"

    def __init__(self, options: Mapping[str, Any]) -> None:
        validated(Section, options, "backends.scpi")

    def power_amplifier(self, options: Mapping[str, Any]) -> ScpiAmplifier:
        """See Backend."""
        table = validated(AmplifierTable, options, "power_amplifier")
        with closed_on_error(_exchange(table, table.commands.identify, "power_amplifier")) as exchange:
            return ScpiAmplifier(exchange, table.commands, table.words)

    def lna(self, options: Mapping[str, Any]) -> ScpiLna:
        """See Backend."""
        table = validated(LnaTable, options, "lna")
        if table.gain not in table.gains:
            raise ConfigError(f"the LNA has no gain {table.gain:g}", where="lna.gain", remedy=f"one of {table.gains}")
        with closed_on_error(_exchange(table, table.commands.identify, "lna")) as exchange:
            return ScpiLna(exchange, table)

    def thermometer(self, options: Mapping[str, Any]) -> ScpiThermometer:
        """See Backend."""
        table = validated(ThermometerTable, options, "thermometer")
        return ScpiThermometer(_exchange(table, table.commands.identify, "thermometer"), table.commands.temperature)


def _exchange(table: DeviceTable, identify: str, device: str) -> Exchange:
    return Exchange(device, lambda: open_wire(table), table.identity, identify)
