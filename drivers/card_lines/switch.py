"""A Tx/Rx switch that is driven by the card's line RX_CONNECT alone, with an optional read-back contact."""

from __future__ import annotations

import time
from typing import Protocol

from drivers.errors import DeviceStateError
from drivers.identity import Identity
from drivers.relay import wait_until_settled
from drivers.timeline import DigitalLine, Timeline
from drivers.tx_rx_switch import SwitchPosition, SwitchTiming, TxRxSwitch

WHERE = "tx_rx_switch"


class CardLines(Protocol):
    """The part of the card that such a switch uses."""

    def timeline(self) -> Timeline | None:
        """The timeline that runs, None if none does."""

    def sample(self) -> int | None:
        """The sample being played, None if nothing runs."""

    def pin(self, board: int, pin: str) -> bool:
        """Level of a DIO pin."""


class LineSwitch(TxRxSwitch):
    """See drivers.tx_rx_switch.TxRxSwitch.

    Outside a timeline the line is low, so the switch goes to TRANSMIT and cannot be commanded to RECEIVE.  Without a
    read-back contact the position is what the line says, in a timeline after the switch's times, and a stuck relay goes
    unnoticed.
    """

    def __init__(self, card: CardLines, timing: SwitchTiming, readback: tuple[int, str] | None) -> None:
        self._card = card
        self._timing = timing
        self._readback = readback

    @property
    def reads_back(self) -> bool:
        """See TxRxSwitch."""
        return self._readback is not None

    def identity(self) -> Identity:
        """See TxRxSwitch."""
        return Identity("", "relay on the card's line", "", "with read-back" if self._readback else "no read-back")

    def timing(self) -> SwitchTiming:
        """See TxRxSwitch."""
        return self._timing

    def position(self) -> SwitchPosition:
        """See TxRxSwitch."""
        if self._readback is not None:
            return SwitchPosition.RECEIVE if self._card.pin(*self._readback) else SwitchPosition.TRANSMIT
        timeline = self._card.timeline()
        sample = self._card.sample()
        if timeline is None or sample is None:
            return SwitchPosition.TRANSMIT
        return self._commanded(timeline, sample)

    def _commanded(self, timeline: Timeline, sample: int) -> SwitchPosition:
        moving = (self._timing.dead_time_s + self._timing.bounce_s) * timeline.clock.rate_hz
        edges = [k for e in timeline.lines if e.line is DigitalLine.RX_CONNECT for k in (e.start_sample, e.stop_sample)]
        if any(edge <= sample < edge + moving for edge in edges):
            return SwitchPosition.MOVING
        high = timeline.is_high(DigitalLine.RX_CONNECT, sample)
        return SwitchPosition.RECEIVE if high else SwitchPosition.TRANSMIT

    def last_move_s(self, target: SwitchPosition) -> float | None:
        """See TxRxSwitch.  Never known."""
        return None

    def to_transmit(self) -> None:
        """See TxRxSwitch.  The line is low already, perhaps for a few ms only: this waits as long as the contacts may
        move.  One that reads back says TRANSMIT as soon as they have left the receiver."""
        if self._card.timeline() is not None:
            raise DeviceStateError("a timeline is running", where=WHERE, remedy="stop the card first")
        time.sleep(self._timing.dead_time_s)
        wait_until_settled(self.position, SwitchPosition.TRANSMIT, self._timing, WHERE)

    def to_receive(self) -> None:
        """See TxRxSwitch.  Always DeviceStateError: only a timeline raises the line."""
        raise DeviceStateError(
            "this switch follows the card's line only", where=WHERE, remedy="connect the receiver within a timeline"
        )

    def close(self) -> None:
        """See TxRxSwitch."""
