"""The low-noise amplifier on a serial line."""

from __future__ import annotations

from drivers.errors import DeviceFault, InputError
from drivers.exchange import Exchange
from drivers.identity import Identity
from drivers.serial_line.controller import command, flag, numbers


class SerialLna:
    """See drivers.lna.Lna."""

    def __init__(self, exchange: Exchange, gain: float) -> None:
        """Sets the gain.  Raises InputError if it has none like that, DeviceProtocolError if this is no LNA."""
        self._exchange = exchange
        self._gains = numbers(exchange, "GAINS?")
        self.set_gain(gain)
        exchange.on_open = lambda _: self.set_gain(self._set)  # one that lost its power has forgotten it

    def identity(self) -> Identity:
        """See Lna."""
        return self._exchange.identity()

    def gains(self) -> tuple[float, ...]:
        """See Lna."""
        return self._gains

    def gain(self) -> float:
        """See Lna."""
        return numbers(self._exchange, "GAIN?")[0]

    def set_gain(self, gain: float) -> None:
        """See Lna.  Raises DeviceFault if it does not read back so."""
        if gain not in self._gains:
            raise InputError(f"no gain {gain:g}", where=self._exchange.where, remedy=f"use one of {self._gains}")
        command(self._exchange, f"GAIN {gain:g}")
        if self.gain() != gain:
            raise DeviceFault(f"the gain reads back {self.gain():g}, not {gain:g}", where=self._exchange.where)
        self._set = gain

    def overloaded(self) -> bool:
        """See Lna."""
        return flag(self._exchange, "OVL?")

    def clear_overload(self) -> None:
        """See Lna."""
        command(self._exchange, "OVL:CLR")

    def close(self) -> None:
        """See Lna."""
        self._exchange.close()
