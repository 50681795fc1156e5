"""Whatever breaks, the next answer belongs to the next question, and comes from the device that was there before."""

from __future__ import annotations

import pytest

from drivers.errors import DeviceLost, DeviceProtocolError, DeviceTimeout
from drivers.exchange import Exchange, parsed_identity
from drivers.identity import Identity
from drivers.testing import ScriptedWires

NAME = "ACME,lamp,7,1.2"


class Lamp:
    def __init__(self) -> None:
        self.name, self.deaf, self.heard = NAME, set(), []

    def __call__(self, text: str) -> str | None:
        self.heard.append(text)
        if text in self.deaf:
            return None
        return self.name if text == "*IDN?" else text.lower() if text.endswith("?") else None


@pytest.fixture
def lamp():
    return Lamp()


@pytest.fixture
def wires(lamp):
    return ScriptedWires(lamp)


def test_a_question_gets_its_answer_and_a_command_none(wires):
    exchange = Exchange("lamp", wires)
    exchange.tell("ON")
    assert exchange.ask("LIT?") == "lit?"
    assert exchange.identity() == Identity("ACME", "lamp", "7", "1.2")


def test_another_device_at_the_start_is_refused_and_the_wire_closed(wires):
    with pytest.raises(DeviceProtocolError, match=r"another device.*ACME,lamp"):
        Exchange("lamp", wires, identity="torch")
    assert wires.opened[0].closed


def test_after_a_time_out_the_wire_is_opened_anew_and_the_device_identified(wires, lamp):
    exchange = Exchange("lamp", wires)
    lamp.deaf = {"LIT?"}
    with pytest.raises(DeviceTimeout):
        exchange.ask("LIT?")
    assert wires.opened[0].closed
    lamp.deaf, lamp.heard = set(), []
    assert exchange.ask("LIT?") == "lit?"
    assert lamp.heard == ["*IDN?", "LIT?"]
    assert len(wires.opened) == 2


def test_another_device_after_a_reconnect_is_refused_until_the_right_one_is_back(wires, lamp):
    exchange = Exchange("lamp", wires)
    lamp.deaf = {"LIT?"}
    with pytest.raises(DeviceTimeout):
        exchange.ask("LIT?")
    lamp.deaf, lamp.name = set(), "ACME,lamp,8,1.2"
    for _ in range(2):
        with pytest.raises(DeviceProtocolError, match="another device"):
            exchange.ask("LIT?")
    lamp.name = NAME
    assert exchange.ask("LIT?") == "lit?"


def test_an_answer_that_comes_after_the_wire_was_reopened_is_nobodys(wires, lamp):
    exchange = Exchange("lamp", wires)
    lamp.deaf = {"LIT?"}
    with pytest.raises(DeviceTimeout):
        exchange.ask("LIT?")
    lamp.deaf, wires.late = set(), ["lit? of old"]
    assert exchange.ask("LIT?") == "lit?"


def test_the_safe_state_is_restored_at_every_opening_before_anything_else(wires, lamp):
    exchange = Exchange("lamp", wires, on_open=lambda e: e.tell("OFF"))
    lamp.deaf = {"LIT?"}
    with pytest.raises(DeviceTimeout):
        exchange.ask("LIT?")
    lamp.deaf, lamp.heard = set(), []
    exchange.tell("ON")
    assert lamp.heard == ["*IDN?", "OFF", "ON"]


def test_a_closed_exchange_stays_closed(wires):
    exchange = Exchange("lamp", wires)
    exchange.close()
    exchange.close()
    with pytest.raises(DeviceLost):
        exchange.ask("LIT?")
    assert len(wires.opened) == 1


@pytest.mark.parametrize("text", ["ACME", "ACME,lamp", "a,b,c,d,e", ""])
def test_an_identity_of_any_length_is_read(text):
    assert parsed_identity(text).manufacturer == text.split(",")[0]


def test_a_device_that_echoes_is_told_so(wires, lamp):
    exchange = Exchange("lamp", wires)
    lamp.name = "*IDN?"
    with pytest.raises(DeviceProtocolError, match=r"'\*IDN\?' is the question itself.*switch its echo off"):
        exchange.identity()
