"""The card's server as the reference describes it: sockets and connecting."""

import socket
import time

import pytest

from tests.kit.emulator_client import Client, configure, connect, control, start, tone, until


def ports(emulator, card=0):
    at = emulator.endpoints()["io_cards"][card]
    return at["host"], at["command_port"], at["data_port"]


def opened(host, port):
    link = socket.create_connection((host, port), timeout=0.2)
    link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return link


def answers(link, wait_s=0.2):
    link.settimeout(wait_s)
    try:
        return link.recv(100)
    except TimeoutError:
        return None


def test_1_a_command_socket_alone_gets_no_answer_until_the_data_socket_comes(emulator):
    host, command, data = ports(emulator)
    link = opened(host, command)
    link.sendall(b"*IDN?\n")
    assert answers(link, 0.1) is None
    with opened(host, data):
        assert answers(link, 5).startswith(b"CUSTOM")


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_1_the_order_of_the_two_connections_does_not_matter(emulator, order):
    host, *both = ports(emulator)
    links = {k: opened(host, both[k]) for k in order}
    links[0].sendall(b"*IDN?\n")
    assert answers(links[0], 5).startswith(b"CUSTOM")


def test_1_a_new_client_evicts_the_old_one_which_sees_the_end_of_its_file(emulator):
    old = connect(emulator)
    assert old.ask("*IDN?") == "CUSTOM,REDPITAYA,0,0.1"
    new = connect(emulator)
    assert new.ask("*IDN?") == "CUSTOM,REDPITAYA,0,0.1"
    for link in (old.command, old.data):
        assert answers(link, 5) == b""


def test_1_a_new_client_zeroes_amplitudes_but_everything_else_survives(emulator):
    client = connect(emulator)
    configure(client)
    tone(client, 212.0, 0.3)
    client.do("RP:DAC:CH0:COMP0:PHASE 0.5", "RP:DAC:CH1:OFFSET 0.25", "RP:DIO:PIN6:SIDEN ON", "RP:ADC:FIRENABLED OFF")
    start(client)
    client.do("RP:TRIGGER:ALIVE ON")
    again = connect(emulator)
    assert again.ask("RP:DAC:CH0:COMP0:AMP?") == "0"
    assert float(again.ask("RP:DAC:CH0:COMP0:FREQ?")) == pytest.approx(212, abs=1e-6)
    assert float(again.ask("RP:DAC:CH0:COMP0:PHA?")) == pytest.approx(0.5)
    assert float(again.ask("RP:DAC:CH1:OFF?")) == pytest.approx(0.25, abs=1e-4)
    answers_now = [again.ask(f"RP:{q}?") for q in ("MODE", "TRIGGER", "TRIGGER:ALIVE", "ADC:DECIMATION", "ADC:FIRE")]
    assert answers_now == ['"ACQUISITION"', '"ON"', '"ON"', "2048", '"OFF"']
    assert again.ask("RP:DIO:PIN6:SIDEN?") == '"ON"'


def test_1_defaults_of_a_server_just_started(client):
    queries = {
        "MODE": '"CONFIGURATION"',
        "ADC:DECIMATION": "16",
        "ADC:FIRENABLED": '"ON"',
        "WATCHDOGMODE": '"OFF"',
        "TRIGGER": '"OFF"',
        "TRIGGER:MODE": '"INTERNAL"',
        "INSTANTRESET:MODE": '"OFF"',
        "DAC:CH0:COMP0:AMP": "0",
        "DAC:CH1:OFFSET": "0",
        "COUNTER:SAMPLESPERSTEP": "0",
        "ADC:WP": "0",
    }
    assert {q: client.ask(f"RP:{q}?") for q in queries} == queries


def test_1_after_a_client_died_half_open_ordinary_clients_are_paired_wrongly_and_starve(emulator):
    host, command, data = ports(emulator)
    opened(host, command).close()
    time.sleep(0.05)
    for _ in range(2):  # command first, then data, as the shipped clients connect
        link = opened(host, command)
        with opened(host, data):
            link.sendall(b"*IDN?\n")
            assert not answers(link, 0.15)
        link.close()
        time.sleep(0.05)


def test_1_data_first_and_waiting_heals_a_half_open_server(emulator):
    host, command, data = ports(emulator)
    opened(host, command).close()
    time.sleep(0.05)
    for _ in range(5):
        sample = opened(host, data)
        if answers(sample, 0.3) == b"":
            continue
        link = opened(host, command)
        link.sendall(b"*IDN?\n")
        assert answers(link, 5).startswith(b"CUSTOM")
        return
    pytest.fail("never healed")


def test_1_replies_to_what_the_old_client_had_asked_reach_the_new_one(emulator):
    old = connect(emulator)
    configure(old)
    start(old)
    old.send("RP:ADC:DATA:PIPELINED? 0,1000000000,600000")  # busy: a chunk of a second in this lab
    assert old.line() == "1"
    old.command.sendall(b"RP:ADC:FIRENABLED?\n")
    new = connect(emulator)
    new.command.sendall(b"\n*IDN?\n")
    lines = [new.line()]
    while not lines[-1].startswith("CUSTOM,"):
        lines.append(new.line())
    assert lines[:-1] == ['"ON"']


def test_1_half_a_command_of_the_old_client_is_put_before_the_first_of_the_new_one(emulator):
    old = connect(emulator)
    configure(old)
    start(old)
    assert old.ask("RP:ADC:DATA:PIPELINED? 0,1000000000,600000") == "1"
    old.command.sendall(b"RP:ADC:FIR")
    new = connect(emulator)
    new.command.sendall(b"\n*IDN?\n")
    assert new.line().startswith("CUSTOM,")


def test_1_a_client_that_leaves_lets_the_next_one_in(emulator):
    connect(emulator).close()
    client = connect(emulator)
    assert client.ask("RP:MODE?") == '"CONFIGURATION"'


def test_ports_in_use_are_a_clear_error(emulator):
    from drivers.errors import ConfigError
    from sim_backend.emulators.emulator import LabEmulator
    from tests.kit.emulator_client import LAB, tables

    table = tables()
    table["io_cards"]["boards"][1]["command_port"] = emulator.endpoints()["io_cards"][0]["data_port"]
    with pytest.raises(ConfigError, match="in use"):
        LabEmulator(table, LAB.parent)


def test_two_cards_have_servers_of_their_own(emulator):
    first, second = connect(emulator, 0), connect(emulator, 1)
    assert [c.ask("*IDN?") for c in (first, second)] == ["CUSTOM,REDPITAYA,0,0.1"] * 2
    first.do("RP:ADC:DECIMATION 2048")
    assert second.ask("RP:ADC:DECIMATION?") == "16"


def test_a_closed_lab_answers_nobody(lab_with):
    emulator = lab_with()
    host, command, data = ports(emulator)
    client = Client(host, command, data)
    client.ask("*IDN?")
    emulator.close()
    assert answers(client.command, 5) == b""
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection((host, command), timeout=1)


def test_the_control_door_says_what_is_wrong_with_a_request(emulator):
    for request in ({"do": "fly"}, {"do": "inject", "kind": "rain"}, {"do": "wire_fault", "kind": "x", "device": "y"}):
        with pytest.raises(AssertionError, match="ok"):
            control(emulator, **request)
    until(lambda: control(emulator, "clock")["world_s"] > 0)
