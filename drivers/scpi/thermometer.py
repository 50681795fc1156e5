"""A thermometer that speaks SCPI."""

from __future__ import annotations

from drivers.exchange import Exchange
from drivers.scpi.dialogue import number


class ScpiThermometer:
    """See drivers.thermometer.Thermometer."""

    def __init__(self, exchange: Exchange, question: str) -> None:
        self._exchange, self._question = exchange, question

    def temperature_c(self) -> float:
        """See Thermometer."""
        return number(self._exchange, self._question)

    def close(self) -> None:
        """See Thermometer."""
        self._exchange.close()
