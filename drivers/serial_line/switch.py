"""The Tx/Rx switch with a serial controller that reads its contacts back."""

from __future__ import annotations

from drivers.errors import DeviceFault, DeviceProtocolError
from drivers.exchange import Exchange
from drivers.identity import Identity
from drivers.relay import wait_until_settled
from drivers.serial_line.controller import command, flag, knows, numbers, query, senseless
from drivers.tx_rx_switch import SwitchPosition, SwitchTiming, TxRxSwitch

POSITIONS = {"TX": SwitchPosition.TRANSMIT, "RX": SwitchPosition.RECEIVE, "MOVING": SwitchPosition.MOVING}
NAMES = {position: text for text, position in POSITIONS.items()}


class SerialSwitch(TxRxSwitch):
    """See drivers.tx_rx_switch.TxRxSwitch.  During a timeline it follows the card's line by itself."""

    def __init__(self, exchange: Exchange) -> None:
        """Raises DeviceProtocolError if this is no Tx/Rx switch."""
        self._exchange = exchange
        times = numbers(exchange, "TIM?")
        if len(times) != 3 or min(times) < 0:
            raise DeviceProtocolError("three times were expected", where=exchange.where, why=f"TIM? says {times}")
        dead_time_s, bounce_s, settle_s = times
        self._timing = SwitchTiming(dead_time_s=dead_time_s, bounce_s=bounce_s, settle_s=settle_s)
        self._measures = knows(exchange, "MOVE? RX")
        self.to_transmit()

    @staticmethod
    def prepare(exchange: Exchange) -> None:
        """After every opening: let it follow the card's line."""
        command(exchange, "FOLLOW ON")
        if not flag(exchange, "FOLLOW?"):
            raise DeviceFault("the switch does not follow its line", where=exchange.where, remedy="check its mode")

    def identity(self) -> Identity:
        """See TxRxSwitch."""
        return self._exchange.identity()

    def timing(self) -> SwitchTiming:
        """See TxRxSwitch."""
        return self._timing

    def position(self) -> SwitchPosition:
        """See TxRxSwitch."""
        answer = query(self._exchange, "POS?")
        if answer not in POSITIONS:
            raise senseless(self._exchange, "POS?", answer)
        return POSITIONS[answer]

    def last_move_s(self, target: SwitchPosition) -> float | None:
        """See TxRxSwitch.  None from a controller that does not know the question."""
        return numbers(self._exchange, f"MOVE? {NAMES[target]}")[0] if self._measures else None

    def to_transmit(self) -> None:
        """See TxRxSwitch.  Raises DeviceStateError while a timeline runs."""
        self._go(SwitchPosition.TRANSMIT, "POS TX")

    def to_receive(self) -> None:
        """See TxRxSwitch.  Raises DeviceStateError while a timeline runs."""
        self._go(SwitchPosition.RECEIVE, "POS RX")

    def close(self) -> None:
        """See TxRxSwitch."""
        try:
            if self.position() is not SwitchPosition.TRANSMIT:
                self.to_transmit()
        finally:
            self._exchange.close()

    def _go(self, target: SwitchPosition, text: str) -> None:
        """Command the contacts and wait until they are there for good: they may have followed their line just now."""
        command(self._exchange, text)
        wait_until_settled(self.position, target, self._timing, self._exchange.where)
