"""A plain power amplifier that one DIO pin of the card enables."""

from __future__ import annotations

from typing import Protocol

from drivers.errors import DeviceFault, DeviceStateError
from drivers.identity import Identity
from drivers.power_amplifier import AmplifierStatus, PowerAmplifier

WHERE = "power_amplifier"
BY_HAND = "remove the cause, then switch the amplifier's mains off and on"


class CardPins(Protocol):
    """The part of the card that such an amplifier uses."""

    def pin(self, board: int, pin: str) -> bool:
        """Level of a DIO pin, read back at the pad."""

    def set_pin(self, board: int, pin: str, high: bool) -> None:
        """Set a DIO pin and read it back; raises DeviceError if it does not follow."""


class PlainAmplifier(PowerAmplifier):
    """See drivers.power_amplifier.PowerAmplifier.

    Enabled and unmuted are one: the pin goes high with `unmute()` only.  Temperature and clipping are not known:
    clipping is never reported.
    """

    def __init__(self, card: CardPins, enable: tuple[int, str], fault: tuple[int, str] | None) -> None:
        self._card = card
        self._enable = enable
        self._fault = fault
        self._wanted = False
        self.disable()

    @property
    def on_card_lines(self) -> bool:
        """See PowerAmplifier."""
        return True

    def identity(self) -> Identity:
        """See PowerAmplifier."""
        return Identity("", f"amplifier enabled by {self._enable[1]}")

    def status(self) -> AmplifierStatus:
        """See PowerAmplifier."""
        live = self._card.pin(*self._enable)
        return AmplifierStatus(
            enabled=self._wanted or live, muted=not live, fault=self._fault_text(), temperature_c=None, clipped=False
        )

    def enable(self) -> None:
        """See PowerAmplifier."""
        fault = self._fault_text()
        if fault is not None:
            raise DeviceFault(f"fault latched: {fault}", where=WHERE, remedy=BY_HAND)
        self._wanted = True

    def disable(self) -> None:
        """See PowerAmplifier."""
        self._wanted = False
        self._card.set_pin(*self._enable, high=False)

    def mute(self) -> None:
        """See PowerAmplifier."""
        self._card.set_pin(*self._enable, high=False)

    def unmute(self) -> None:
        """See PowerAmplifier."""
        if not self._wanted:
            raise DeviceStateError("the amplifier is disabled", where=WHERE, remedy="enable it first")
        self._card.set_pin(*self._enable, high=True)

    def reset_fault(self) -> None:
        """See PowerAmplifier.  It has no reset input, so that only the enable pin is lowered."""
        self.disable()
        fault = self._fault_text()
        if fault is not None:
            raise DeviceFault(
                f"the fault stays: {fault}",
                where=WHERE,
                why=f"an amplifier on digital lines has no reset, and with {self._enable[1]} low it did not recover",
                remedy=BY_HAND,
            )

    def close(self) -> None:
        """See PowerAmplifier."""
        self.disable()

    def _fault_text(self) -> str | None:
        return "the fault pin is high" if self._fault is not None and self._card.pin(*self._fault) else None
