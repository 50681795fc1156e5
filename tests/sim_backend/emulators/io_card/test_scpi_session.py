"""What the real server said to 1355 commands, the emulator says, too; see tests/data/daq_server."""

from __future__ import annotations

import socket
import threading
import time
import tomllib
from dataclasses import dataclass

import pytest

from sim_backend.world import shot
from tests.kit.data import DATA
from tests.kit.emulator_client import connect, lab

FOLDER = DATA / "daq_server"
MARK = b"CUSTOM,REDPITAYA,0,0.1\r\n"


@dataclass
class Exchange:
    """One command, the bytes on the data socket, and the answer."""

    asked: str
    data: bytes = b""
    answer: bytes = b""


def recorded():
    """All exchanges in order."""
    out = []
    for line in (FOLDER / "conversation.txt").read_text().splitlines():
        kind, rest = line[:1], line[2:]
        if kind == ">":
            out.append(Exchange(rest))
        elif kind == "+":
            out[-1].data = bytes.fromhex(rest)
        elif kind == "<":
            out[-1].answer = rest.encode().decode("unicode_escape").encode("latin1")
    return out


def replayed(client, exchange):
    """What the emulator answers, up to the mark."""
    client.command.sendall(exchange.asked.encode() + b"\n")
    client.data.sendall(exchange.data)
    time.sleep(1e-3)
    client.command.sendall(b"*IDN?\n")
    heard = b""
    while not heard.endswith(MARK):
        client.command.setsockopt(socket.IPPROTO_TCP, socket.TCP_QUICKACK, 1)
        part = client.command.recv(4096)
        assert part, f"the emulator died of {exchange.asked!r}"
        heard += part
    return heard.removesuffix(MARK)


def test_the_emulator_answers_byte_for_byte_as_the_real_server_did_except_where_a_reason_is_given():
    known = tomllib.loads((FOLDER / "differences.toml").read_text())["difference"]
    emulator = lab()
    emulator.cards.boards[0].calibration_flags = 0  # nothing in the memory
    client = connect(emulator)
    exchanges, different = recorded(), []
    for exchange in exchanges:
        answer = replayed(client, exchange)
        if answer != exchange.answer:
            different.append((exchange.asked, answer))
    client.close()
    emulator.close()
    assert len(exchanges) > 1300
    assert different == [(d["asked"], d["emulator"].encode()) for d in known]
    assert all(d["reason"] for d in known)


@pytest.mark.parametrize("fatal", ["RP:DAC:CH0:COMP3:SIG?", "RP:DAC:CH2:COMP0:SIG?", "RP:DAC:CH2:RAMPING:ENABLE?"])
def test_what_the_real_server_dies_of_the_emulated_one_does_too(fatal):
    emulator = lab()
    client = connect(emulator)
    client.send(fatal)
    assert client.command.recv(100) == b""
    emulator.close()


def test_a_client_that_comes_while_its_predecessor_is_still_being_ended_finds_the_server_hung():
    emulator = lab()
    for board in emulator.cards.boards:
        board.options = board.options.model_copy(update={"ending_s": 5.0})
    connect(emulator).close()
    time.sleep(0.02)
    again = connect(emulator)
    assert again.silent("*IDN?", 0.3)
    third = connect(emulator)
    assert third.silent("*IDN?", 0.3)
    emulator.close()


def test_an_upload_that_stays_away_locks_everybody_out_and_one_whose_connection_is_dead_counts_as_zeros():
    emulator = lab()
    client = connect(emulator)
    client.do("RP:DAC:SEQ:SAMP 16", "RP:DAC:SEQ:CHAN 1")
    client.send("RP:DAC:SEQ:LUT 4,1")
    second = connect(emulator)
    assert second.silent("*IDN?", 0.3)
    client.data.shutdown(socket.SHUT_RDWR)
    assert second.line() == "1"  # meant for the first
    assert second.line().startswith("CUSTOM,")
    emulator.close()


def test_the_emergency_input_holds_the_stepper_so_that_the_sequence_seems_to_run_for_ever():
    emulator = lab()
    client = connect(emulator)
    client.do("RP:ADC:DEC 2048", "RP:INSTANTRESET:MODE ON", "RP:DAC:SEQ:SAMP 16", "RP:DAC:SEQ:CHAN 1")
    assert client.upload("RP:DAC:SEQ:LUT 4,1", [0.0] * 4) == "1"
    client.do("RP:DAC:SEQ:SET", "RP:MODE ACQUISITION", "RP:TRIGGER ON")
    with emulator.world.lock:
        emulator.cards.boards[0].instant_reset(True)
    time.sleep(0.2)
    held = int(client.ask("RP:STATUS?")) & 16
    assert (held, client.ask("RP:INSTANTRESET:TRIGGERED?")) == (16, "1")
    emulator.close()


def test_who_asks_the_world_all_the_time_and_who_talks_to_a_card_do_not_wait_for_each_other():
    emulator = lab()
    at, over = emulator.endpoints()["control"], threading.Event()

    def poll():
        with socket.create_connection((at["host"], at["port"]), 5) as link, link.makefile("rwb") as stream:
            while not over.is_set():
                stream.write(b'{"do": "outputs"}\n{"do": "violations"}\n')
                stream.flush()
                assert stream.readline()
                assert stream.readline()

    pollers = [threading.Thread(target=poll, daemon=True) for _ in range(3)]
    for each in pollers:
        each.start()
    client = connect(emulator)
    client.do("RP:ADC:DEC 2048")
    for _ in range(40):
        client.do(
            "RP:MODE ACQUISITION", "RP:TRIGGER ON", "RP:DAC:CH0:OFF 0.01", "RP:TRIGGER OFF", "RP:MODE CONFIGURATION"
        )
    over.set()
    for each in pollers:
        each.join(10)
    assert not any(each.is_alive() for each in pollers)
    emulator.close()


def test_who_holds_the_worlds_lock_gets_a_shot_that_somebody_else_is_computing(monkeypatch):
    """The card's conversation holds it, the control port computes."""
    emulator = lab()
    world, begun, go_on = emulator.world, threading.Event(), threading.Event()
    simulate = shot.simulate

    def slow(setup):
        begun.set()
        go_on.wait(5)
        return simulate(setup)

    monkeypatch.setattr(shot, "simulate", slow)
    client = connect(emulator)
    client.do("RP:ADC:DEC 2048", "RP:MODE ACQUISITION", "RP:TRIGGER ON")
    found = []

    def hold():
        with world.lock:
            go_on.set()
            found.append(world.shot_simulator.result())

    computing = threading.Thread(target=world.shot_simulator.result, daemon=True)
    computing.start()
    assert begun.wait(5)
    holding = threading.Thread(target=hold, daemon=True)
    holding.start()
    for each in (holding, computing):
        each.join(10)
        assert not each.is_alive()
    assert found
    emulator.close()
