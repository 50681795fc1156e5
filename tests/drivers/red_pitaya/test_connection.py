"""The sockets: whatever state the server is in, commands and answers end up in step, or there is a clear error."""

from __future__ import annotations

import socket
import threading
import time

import pytest

from drivers.errors import DeviceLost, DeviceNotFound, DeviceProtocolError, DeviceTimeout
from drivers.red_pitaya import connection as module
from drivers.red_pitaya.connection import Connection
from tests.kit.scripted_daq_server import ScriptedDaqServer, answering, lines, listener

IDENTITY = b"CUSTOM,REDPITAYA,0,0.1\r\n"


@pytest.fixture(autouse=True)
def impatient(monkeypatch):
    monkeypatch.setattr(module, "MARK_S", 0.3)
    monkeypatch.setattr(module, "HALF_OPEN_S", 0.05)
    monkeypatch.setattr(module, "ATTEMPTS", 2)


@pytest.fixture
def serve():
    made = []

    def start(*scripts):
        made.append(ScriptedDaqServer(*scripts))
        return made[-1].ports

    yield start
    for server in made:
        server.close()


def opened(ports, timeout_s=0.3):
    return Connection.open("127.0.0.1", *ports, timeout_s)


def test_nobody_at_the_address_is_said_at_once():
    with listener() as free:
        port = free.getsockname()[1]
    with pytest.raises(DeviceNotFound, match=f"127.0.0.1:{port}"):
        opened((port, port))


def test_a_host_that_has_no_name_is_not_found():
    with pytest.raises(DeviceNotFound, match=r"no-such-card\.invalid"):
        Connection.open("no-such-card.invalid", 5025, 5026, 0.3)


def test_a_server_that_stays_silent_is_a_time_out(serve):
    silence = answering({"*IDN?": None})
    with pytest.raises(DeviceTimeout):
        opened(serve(silence, silence))


def test_something_else_on_the_port_is_named_with_what_it_says(serve):
    other = answering({"*IDN?": "ACME,multimeter,1,2"})
    with pytest.raises(DeviceProtocolError, match=r"no RedPitayaDAQServer.*ACME,multimeter"):
        opened(serve(other, other))


def test_answers_meant_for_the_former_client_are_passed_over(serve):
    def stale(command, data):
        command.sendall(b"0\r\n1\r\n")
        following = lines(command)
        assert following() == "*IDN?"
        command.sendall(b'"OUT"\r\n' + IDENTITY)
        assert following() == "RP:ADC:DECIMATION?"
        command.sendall(b"2048\r\n")

    assert opened(serve(stale)).ask("RP:ADC:DECIMATION?") == 2048


def test_a_half_open_server_is_healed_by_connecting_the_data_socket_first():
    command, data = listener(), listener()

    def half_open():
        data.accept()[0].close()  # what a server does that waited for the data socket of a dead client
        first = command.accept()[0]
        second = data.accept()[0]
        lines(first)()
        first.sendall(IDENTITY)
        second.recv(1)

    thread = threading.Thread(target=half_open, daemon=True)
    thread.start()
    connection = opened((command.getsockname()[1], data.getsockname()[1]))
    connection.close()
    thread.join(5)
    assert not thread.is_alive()
    command.close()
    data.close()


def test_a_reply_in_pieces_is_one_reply(serve):
    def pieces(command, data):
        following = lines(command)
        following()
        for piece in (b"CUS", b"TOM,", b"REDPITAYA,0,0.1", b"\r", b"\n"):
            command.sendall(piece)
            time.sleep(0.002)
        following()
        command.sendall(b"20")
        time.sleep(0.002)
        command.sendall(b"48\r\n")

    assert opened(serve(pieces)).ask("RP:ADC:DECIMATION?") == 2048


def test_every_command_is_one_segment_with_its_end(serve, monkeypatch):
    received = []

    def watching(command, data):
        for _ in range(3):
            received.append(command.recv(4096))
            command.sendall(IDENTITY if b"IDN" in received[-1] else b"1\r\n")

    connection = opened(serve(watching))
    connection.ask("RP:ADC:DECIMATION 2048")
    connection.ask("RP:TRIGGER:MODE INTERNAL")
    assert received == [b"\n*IDN?\n", b"RP:ADC:DECIMATION 2048\n", b"RP:TRIGGER:MODE INTERNAL\n"]


@pytest.mark.parametrize(("reply", "reason"), [("-5", "wrong server mode"), ("-2", "out of range"), ("0", "refused")])
def test_a_refusal_is_an_error_that_says_why(serve, reply, reason):
    connection = opened(serve(answering({"RP:MODE ACQUISITION": reply})))
    with pytest.raises(DeviceProtocolError, match=reason):
        connection.ask("RP:MODE ACQUISITION")


@pytest.mark.parametrize("reply", ["", "abc", "1.5x", "\x00\x01"])
def test_garbage_is_an_error_that_quotes_it(serve, reply):
    connection = opened(serve(answering({"RP:ADC:WP?": reply})))
    with pytest.raises(DeviceProtocolError, match="makes no sense"):
        connection.ask("RP:ADC:WP?")


def test_after_a_refusal_commands_and_answers_are_still_in_step(serve):
    table = {"RP:MODE ACQUISITION": "-5", "RP:ADC:WP?": "7", "RP:ADC:DECIMATION?": "2048"}
    connection = opened(serve(answering(table)))
    with pytest.raises(DeviceProtocolError):
        connection.ask_all(["RP:MODE ACQUISITION", "RP:ADC:WP?"])
    assert connection.ask("RP:ADC:DECIMATION?") == 2048


def test_a_command_without_answer_ends_the_connection_so_that_a_late_one_fools_nobody(serve):
    connection = opened(serve(answering({"RP:ADC:WP?": "7"})))
    with pytest.raises(DeviceTimeout, match="RP:MODE"):
        connection.ask("RP:MODE?")
    with pytest.raises(DeviceLost, match=r"not answered"):
        connection.ask("RP:ADC:WP?")


def test_a_header_that_is_not_in_the_table_is_never_sent(serve):
    connection = opened(serve(answering({})))
    with pytest.raises(KeyError):
        connection.ask("RP:TRIG:ALV ON")


def test_an_eviction_is_noticed(serve):
    def evict(command, data):
        lines(command)()
        command.sendall(IDENTITY)
        command.close()
        data.close()

    connection = opened(serve(evict))
    with pytest.raises(DeviceLost, match="another client"):
        connection.ask("RP:ADC:WP?")


def test_a_refused_upload_makes_the_connection_unusable(serve):
    connection = opened(serve(answering({"RP:DAC:SEQ:LUT 1,1": "-7", "RP:ADC:WP?": "7"})))
    with pytest.raises(DeviceProtocolError, match="cannot be configured now"):
        connection.upload("RP:DAC:SEQ:LUT 1,1", b"\0" * 8)
    with pytest.raises(DeviceLost, match="upload"):
        connection.ask("RP:ADC:WP?")


def test_samples_that_stay_away_and_a_stream_that_breaks_off_are_different_errors(serve):
    def half(command, data):
        lines(command)()
        command.sendall(IDENTITY)
        data.sendall(b"\1" * 10)
        time.sleep(0.3)
        data.sendall(b"\2" * 10)
        data.shutdown(socket.SHUT_RDWR)

    connection = opened(serve(half))
    target = bytearray(20)
    with pytest.raises(DeviceTimeout, match="no samples"):
        connection.receive_into(memoryview(target), 0.05)
    with pytest.raises(DeviceLost):
        connection.receive_into(memoryview(target), 2.0)


def test_closing_from_another_thread_wakes_a_reader(serve):
    connection = opened(serve(answering({})))
    threading.Timer(0.05, connection.close).start()
    with pytest.raises(DeviceLost):
        connection.receive_into(memoryview(bytearray(4)), 10.0)


def test_garbage_in_place_of_the_first_answer_is_overcome_by_connecting_again(serve):
    ports = serve(answering({"*IDN?": "\x01\x7fgarbage"}), answering({"RP:ADC:WP?": "7"}))
    connection = opened(ports)
    assert connection.ask("RP:ADC:WP?") == 7
    connection.close()


@pytest.mark.parametrize(("take_over_s", "connections"), [(0.0, 2), (60.0, 5)])
def test_a_take_over_from_a_dead_card_tries_no_longer_than_somebody_can_wait(
    serve, monkeypatch, take_over_s, connections
):
    tried = []

    def silent(command, data):
        tried.append(True)
        command.recv(1)

    monkeypatch.setattr(module, "ATTEMPTS", 4)
    monkeypatch.setattr(module, "TAKE_OVER_S", take_over_s)
    with pytest.raises(DeviceTimeout):
        Connection.take_over("127.0.0.1", *serve(*[silent] * 10), 0.3)
    assert len(tried) == connections
