"""The serial controller of the Tx/Rx switch (docs/reference/wiring.md)."""

from __future__ import annotations

from drivers.tx_rx_switch import SwitchPosition

from ..io_card.session import Cards
from .serial_port import BAD_ARGUMENT, NOT_NOW, UNKNOWN

NAMES = {SwitchPosition.TRANSMIT: "TX", SwitchPosition.RECEIVE: "RX", SwitchPosition.MOVING: "MOVING"}


class SwitchController:
    """Follows the cards' line after power-on, or moves the contacts itself."""

    def __init__(self, cards: Cards, serial: str) -> None:
        self._cards = cards
        self._world = cards.world
        self._serial = serial

    def execute(self, line: str) -> str:
        """See SerialDevice."""
        options = self._world.options.switch
        match line.split():
            case ["*IDN?"]:
                return f"Simulated,Tx/Rx switch 3x,{self._serial},1.0"
            case ["POS?"]:
                return NAMES[self._world.contacts().position(self._world.clock.monotonic_s())]
            case ["MOVE?", ("TX" | "RX") as word]:
                return self._took(word)
            case ["TIM?"]:
                return f"{options.dead_time_s:g},{options.bounce_s:g},{options.settle_s:g}"
            case ["FOLLOW?"]:
                return str(int(self._cards.switch_override is None))
            case ["FOLLOW", ("ON" | "OFF") as word]:
                return self._follow(word == "ON")
            case ["POS", ("TX" | "RX") as word]:
                return self._move(word == "RX")
            case ["POS" | "FOLLOW" | "MOVE?", *_]:
                return BAD_ARGUMENT
        return UNKNOWN

    def _took(self, word: str) -> str:
        contacts = self._world.contacts()
        target = SwitchPosition.RECEIVE if word == "RX" else SwitchPosition.TRANSMIT
        if contacts.heading() is target and self._world.clock.monotonic_s() < contacts.arrival_s():
            return NOT_NOW
        return f"{contacts.last_move_s.get(target, 0.0):.6f}"

    def _follow(self, on: bool) -> str:
        heading = self._world.contacts().heading() is SwitchPosition.RECEIVE
        self._cards.override_switch(None if on else heading)
        return "OK"

    def _move(self, receive: bool) -> str:
        if self._cards.switch_override is not None:
            self._cards.override_switch(receive)
            return "OK"
        if self._world.is_running():
            return NOT_NOW
        self._world.move_contacts(SwitchPosition.RECEIVE if receive else SwitchPosition.TRANSMIT)
        return "OK"
