"""A low-noise amplifier that speaks SCPI."""

from __future__ import annotations

from drivers.errors import DeviceFault, InputError
from drivers.exchange import Exchange
from drivers.identity import Identity
from drivers.scpi.dialogue import number, yes
from drivers.scpi.options import LnaTable


class ScpiLna:
    """See drivers.lna.Lna."""

    def __init__(self, exchange: Exchange, table: LnaTable) -> None:
        self._exchange = exchange
        self._table = table
        self.set_gain(table.gain)
        exchange.on_open = lambda _: self.set_gain(self._set)  # one that lost its power has forgotten it

    def identity(self) -> Identity:
        """See Lna."""
        return self._exchange.identity()

    def gains(self) -> tuple[float, ...]:
        """See Lna."""
        return self._table.gains

    def gain(self) -> float:
        """See Lna."""
        return number(self._exchange, self._table.commands.gain)

    def set_gain(self, gain: float) -> None:
        """See Lna.  Raises DeviceFault if it does not read back so."""
        if gain not in self.gains():
            raise InputError(f"no gain {gain:g}", where=self._exchange.where, remedy=f"use one of {self.gains()}")
        self._exchange.tell(self._table.commands.set_gain.replace("{gain}", f"{gain:g}"))
        found = self.gain()
        if found != gain:
            raise DeviceFault(f"the gain reads back {found:g}, not {gain:g}", where=self._exchange.where)
        self._set = gain

    def overloaded(self) -> bool:
        """See Lna.  False where the device does not report it."""
        question = self._table.commands.overload
        return bool(question) and yes(self._exchange, question, self._table.words)

    def clear_overload(self) -> None:
        """See Lna."""
        if self._table.commands.clear_overload:
            self._exchange.tell(self._table.commands.clear_overload)

    def close(self) -> None:
        """See Lna."""
        self._exchange.close()
