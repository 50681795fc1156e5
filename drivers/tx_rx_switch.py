"""Contract of the Tx/Rx switch, which connects the coils to the power amplifier or to the receiver, never to both."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

from drivers.identity import Identity


class SwitchPosition(StrEnum):
    """Where the contacts are, as read back from the switch."""

    TRANSMIT = "transmit"
    RECEIVE = "receive"
    MOVING = "moving"


@dataclass(frozen=True, kw_only=True)
class SwitchTiming:
    """dead_time_s: from the command until the contacts have left the old side and reached the new one;
    bounce_s: how long they may bounce after that; settle_s: how long the receiver then rings before data are good."""

    dead_time_s: float
    bounce_s: float
    settle_s: float

    @property
    def total_s(self) -> float:
        """From the command until receive data are good."""
        return self.dead_time_s + self.bounce_s + self.settle_s


class TxRxSwitch(Protocol):
    """Tx/Rx switch.  Its rest position is TRANSMIT: the receiver is disconnected unless it is commanded.

    During a running timeline the switch follows the card's line RX_CONNECT, and the two commands below may raise
    DeviceStateError; outside it they move the contacts.  A class that derives from this one inherits the defaults.
    """

    @property
    def reads_back(self) -> bool:
        """Whether `position` reads the contacts; otherwise it is assumed from the line, and a stuck relay is missed."""
        return True

    def identity(self) -> Identity:
        """Identity of the switch.  Raises DeviceTimeout, DeviceProtocolError."""

    def timing(self) -> SwitchTiming:
        """How long a change of position takes; constant while it is open."""

    def position(self) -> SwitchPosition:
        """The position read back from the contacts, not the last command.  Raises DeviceTimeout."""

    def last_move_s(self, target: SwitchPosition) -> float | None:
        """How long the last move to `target` took, from the command until the contacts came to rest, bounces included,
        as the switch has measured it; 0 if there was none, None if it cannot measure.  Not while the contacts move."""

    def to_transmit(self) -> None:
        """Disconnect the receiver.  Returns when read-back confirms TRANSMIT; raises DeviceFault if it does not.

        It is called a few ms after RX_CONNECT has fallen, and waits until moving contacts have stopped bouncing.
        """

    def to_receive(self) -> None:
        """Connect the receiver.  Returns when read-back confirms RECEIVE; raises DeviceFault if it does not.

        Call it through the interlock only: the switch does not know whether the amplifier is on.
        """

    def close(self) -> None:
        """Go to TRANSMIT and release the device.  Idempotent."""
