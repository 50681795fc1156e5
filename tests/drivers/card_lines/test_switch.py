"""A relay on the card's line is given the time that its contacts need."""

from __future__ import annotations

import time

import pytest

from drivers.card_lines.switch import LineSwitch
from drivers.errors import DeviceFault
from drivers.timeline import Timeline
from drivers.tx_rx_switch import SwitchPosition, SwitchTiming

TIMING = SwitchTiming(dead_time_s=0.02, bounce_s=0.01, settle_s=0.0)


class Card:
    """Its contact reads back `levels`, one each question, the last one for ever."""

    def __init__(self, *levels: bool) -> None:
        self._levels = list(levels)

    def timeline(self) -> Timeline | None:
        return None

    def sample(self) -> int | None:
        return None

    def pin(self, board: int, pin: str) -> bool:
        return self._levels.pop(0) if len(self._levels) > 1 else self._levels[0]


def test_contacts_that_have_not_left_the_receiver_yet_are_waited_for() -> None:
    switch = LineSwitch(Card(*[True] * 5, False), TIMING, (0, "DIO5_N"))
    switch.to_transmit()
    assert switch.position() is SwitchPosition.TRANSMIT


def test_contacts_that_bounce_are_looked_at_when_they_rest() -> None:
    card = Card(True, False, True, True, False)
    LineSwitch(card, TIMING, (0, "DIO5_N")).to_transmit()
    assert not card.pin(0, "DIO5_N"), "it was waited for the bounce, too"


def test_contacts_that_stay_are_a_fault() -> None:
    with pytest.raises(DeviceFault, match=r"on receive, not on transmit.*check the relay"):
        LineSwitch(Card(True), TIMING, (0, "DIO5_N")).to_transmit()


@pytest.mark.parametrize("readback", [None, (0, "DIO5_N")])
def test_its_times_pass_in_any_case(readback: tuple[int, str] | None) -> None:
    """A contact that reads back high on RECEIVE says TRANSMIT as soon as it has left the receiver."""
    since = time.monotonic()
    LineSwitch(Card(False), TIMING, readback).to_transmit()
    assert time.monotonic() - since >= TIMING.dead_time_s + TIMING.bounce_s
