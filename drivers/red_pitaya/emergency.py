"""The card's emergency input, DIO3_P: it switches the outputs off at once, and they stay so until the trigger falls."""

from __future__ import annotations

from drivers.errors import DeviceFault

EMERGENCY = "RP:INSTANTRESET:TRIGGERED?"  # since the trigger
EMERGENCY_PIN = "RP:INSTANTRESET:STATUS?"  # now


def emergency_stop(
    where: str, what: str = "the emergency input switched the outputs off during the shot"
) -> DeviceFault:
    """The error for a card that was stopped by its input DIO3_P."""
    return DeviceFault(what, where=where, remedy="find out why DIO3_P of the card is high")
