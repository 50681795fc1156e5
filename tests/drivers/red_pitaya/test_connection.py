"""The sockets: whatever state the server is in, commands and answers end up in step, or there is a clear error."""

from __future__ import annotations

import contextlib
import os
import socket
import threading
import time

import pytest

from drivers.errors import DeviceLost, DeviceNotFound, DeviceProtocolError, DeviceTimeout
from drivers.red_pitaya import connection as sockets
from drivers.red_pitaya import pairing as module
from drivers.red_pitaya.pairing import open_pair, take_over
from drivers.red_pitaya.ports import peek
from tests.kit.command_line import wait_for
from tests.kit.scripted_daq_server import ScriptedDaqServer, answering, lines, listener, prove

TCP_REPAIR = 19  # of Linux: closed then, it tells the other end nothing
WAITING = 2  # connections, at each port of a server that stands still
OFF = "RP:DAC:CHANNEL0:OFFSET 0"
IDENTITY = b"CUSTOM,REDPITAYA,0,0.1\r\n"


@pytest.fixture(autouse=True)
def impatient(monkeypatch):
    monkeypatch.setattr(sockets, "MARK_S", 0.3)
    monkeypatch.setattr(module, "PROOF_S", 0.3)
    monkeypatch.setattr(module, "HALF_OPEN_S", 0.05)
    monkeypatch.setattr(module, "QUEUE_S", 0.3)
    monkeypatch.setattr(module, "ATTEMPTS", 2)
    monkeypatch.setattr(module, "_UNSERVED", {})  # ports are used again


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
    return open_pair("127.0.0.1", ports, timeout_s, ())


def noting(heard):
    """A server that lets itself be connected, then notes each command in `heard` and answers nothing."""

    def script(command, data):
        lines(command)()
        command.sendall(IDENTITY)
        prove(command, data)
        for said in command.makefile("r"):
            heard.append(said.strip())

    return script


def test_nobody_at_the_address_is_said_at_once():
    with listener() as free:
        port = free.getsockname()[1]
    with pytest.raises(DeviceNotFound, match=f"127.0.0.1:{port}"):
        opened((port, port))


def test_a_host_that_has_no_name_is_not_found():
    with pytest.raises(DeviceNotFound, match=r"no-such-card\.invalid"):
        open_pair("no-such-card.invalid", (5025, 5026), 0.3, ())


def test_a_server_that_stays_silent_is_a_time_out(serve):
    silence = answering({"*IDN?": None})
    with pytest.raises(DeviceTimeout):
        opened(serve(silence, silence))


def test_something_else_on_the_port_is_named_with_what_it_says(serve):
    other = answering({"*IDN?": "ACME,multimeter,1,2"})
    with pytest.raises(DeviceProtocolError, match=r"no RedPitayaDAQServer.*ACME,multimeter"):
        opened(serve(other, other))


@pytest.mark.parametrize("said", [bytes(1000), b"hello\r\n" * 100])
def test_something_that_never_stops_talking_is_named_and_not_listened_to_for_ever(serve, said):
    def flooding(command, _):
        while True:
            command.sendall(said)

    begun_s = time.monotonic()
    with pytest.raises(DeviceProtocolError, match="no RedPitayaDAQServer"):
        opened(serve(flooding, flooding))
    assert time.monotonic() - begun_s < 5.0


def test_answers_meant_for_the_former_client_are_passed_over(serve):
    def stale(command, data):
        command.sendall(b"0\r\n1\r\n")
        following = lines(command)
        assert following() == "*IDN?"
        command.sendall(b'"OUT"\r\n' + IDENTITY)
        prove(command, data)
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
        prove(first, second)
        second.recv(1)

    thread = threading.Thread(target=half_open, daemon=True)
    thread.start()
    connection = opened((command.getsockname()[1], data.getsockname()[1]))
    connection.close()
    thread.join(5)
    assert not thread.is_alive()
    command.close()
    data.close()


def test_a_server_that_still_ends_the_client_before_and_hangs_up_on_the_next_is_asked_again(serve):
    """Its old thread closes whatever connection is the current one; on a slow card that may be the new one."""

    def hung_up(command, data):
        lines(command)()
        command.sendall(IDENTITY)
        command.close()
        data.close()

    assert opened(serve(hung_up, answering({"RP:ADC:DECIMATION?": "2048"}))).ask("RP:ADC:DECIMATION?") == 2048
    with pytest.raises(DeviceLost, match="the card is gone"):
        opened(serve(hung_up, hung_up))


def test_a_reply_in_pieces_is_one_reply(serve):
    def pieces(command, data):
        following = lines(command)
        following()
        for piece in (b"CUS", b"TOM,", b"REDPITAYA,0,0.1", b"\r", b"\n"):
            command.sendall(piece)
            time.sleep(0.002)
        prove(command, data)
        following()
        command.sendall(b"20")
        time.sleep(0.002)
        command.sendall(b"48\r\n")

    assert opened(serve(pieces)).ask("RP:ADC:DECIMATION?") == 2048


def test_every_command_is_one_segment_with_its_end(serve, monkeypatch):
    received = []

    def watching(command, data):
        for number in range(3):
            if number == 1:
                prove(command, data)
            received.append(command.recv(4096))
            command.sendall(IDENTITY if b"IDN" in received[-1] else b"1\r\n")

    connection = opened(serve(watching))
    connection.ask("RP:ADC:DECIMATION 2048")
    connection.ask("RP:TRIGGER:MODE INTERNAL")
    assert received == [b"\n*IDN?\n", b"RP:ADC:DECIMATION 2048\n", b"RP:TRIGGER:MODE INTERNAL\n"]


@pytest.mark.parametrize(("reply", "reason"), [("-5", "wrong server mode"), ("-2", "out of range"), ("0", "refused")])
def test_a_refusal_is_an_error_that_says_why(serve, reply, reason):
    connection = opened(serve(answering({"RP:MODE CONFIGURATION": reply})))
    with pytest.raises(DeviceProtocolError, match=reason):
        connection.ask("RP:MODE CONFIGURATION")


@pytest.mark.parametrize("reply", ["", "abc", "1.5x", "\x00\x01"])
def test_garbage_is_an_error_that_quotes_it(serve, reply):
    connection = opened(serve(answering({"RP:ADC:WP?": reply})))
    with pytest.raises(DeviceProtocolError, match="makes no sense"):
        connection.ask("RP:ADC:WP?")


def test_after_a_refusal_commands_and_answers_are_still_in_step(serve):
    table = {"RP:MODE CONFIGURATION": "-5", "RP:ADC:WP?": "7", "RP:ADC:DECIMATION?": "2048"}
    connection = opened(serve(answering(table)))
    with pytest.raises(DeviceProtocolError):
        connection.ask_all(["RP:MODE CONFIGURATION", "RP:ADC:WP?"])
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
        prove(command, data)
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
        prove(command, data)
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


def test_a_card_whose_answers_stay_away_still_hears_that_a_line_goes_low(serve):
    heard, low = [], "RP:DIO:PIN7:SIDEP OFF"

    def waits():
        with contextlib.suppress(DeviceLost):
            connection.ask("RP:ADC:WP?")

    connection = opened(serve(noting(heard)), 60.0)
    waiting = threading.Thread(target=waits)
    waiting.start()
    wait_for(lambda: heard == ["RP:ADC:WP?"])
    connection.send_final([low])
    wait_for(lambda: heard == ["RP:ADC:WP?", low])
    connection.close()
    waiting.join()
    connection.send_final([low])  # no server is left, and no error is raised


def test_after_the_last_word_no_other_command_is_sent(serve):
    heard = []

    connection = opened(serve(noting(heard)))
    connection.send_final([OFF])
    for of_no_use in (
        lambda: connection.ask("RP:DIO:PIN7:SIDEP ON"),
        lambda: connection.post("RP:INSTANTRESET:TRIGGERED?"),
        lambda: connection.upload("RP:DAC:SEQ:LUT 1,1", bytes(4)),
    ):
        with pytest.raises(DeviceLost, match="its lines were set low"):
            of_no_use()
    connection.close()
    wait_for(lambda: heard == [OFF])


def test_closing_from_another_thread_wakes_a_reader(serve):
    connection = opened(serve(answering({})))
    threading.Timer(0.05, connection.close).start()
    with pytest.raises(DeviceLost):
        connection.receive_into(memoryview(bytearray(4)), 10.0)


def test_garbage_in_place_of_the_first_answer_is_overcome_by_connecting_again(serve):
    def garbage(command, data):
        lines(command)()
        command.sendall(b"\x01\x7fgarbage\r\n")

    ports = serve(garbage, answering({"RP:ADC:WP?": "7"}))
    connection = opened(ports)
    assert connection.ask("RP:ADC:WP?") == 7
    connection.close()


@pytest.mark.parametrize(("take_over_s", "least_s"), [(0.0, 0.6), (60.0, 1.5)])
def test_a_take_over_from_a_dead_card_tries_no_longer_than_somebody_can_wait(monkeypatch, take_over_s, least_s):
    monkeypatch.setattr(module, "ATTEMPTS", 4)
    monkeypatch.setattr(module, "TAKE_OVER_S", take_over_s)
    with halted() as (server, old):
        begun_s = time.monotonic()
        with pytest.raises(DeviceTimeout, match="its DAQ server takes the connection and says nothing"):
            take_over(old, "127.0.0.1", server.ports, 0.3, ())
        assert least_s <= time.monotonic() - begun_s <= least_s + 0.5


@contextlib.contextmanager
def halted():
    """A server that has served one client, its connection, and stands still from then on."""
    server = Halted()
    try:
        threading.Thread(target=server.serve, daemon=True).start()
        yield server, opened(server.ports)
    finally:
        server.close()


class Halted:
    """What comes while it stands still waits in the queues of its ports."""

    def __init__(self):
        self._listeners = listener(), listener()
        self.ports = self._listeners[0].getsockname()[1], self._listeners[1].getsockname()[1]
        self.kept = []
        self.gone = threading.Event()

    def serve(self):
        """A client; its end."""
        with contextlib.suppress(OSError):
            answering({"RP:ADC:WP?": "7"})(self._listeners[0].accept()[0], self._listeners[1].accept()[0])
            self.gone.set()

    def go_on(self):
        """Everybody in turn, each of whom throws out the one before."""

        def client(*pair):
            with contextlib.suppress(OSError):
                answering({"RP:ADC:WP?": "7"})(*pair)

        pair = ()
        with contextlib.suppress(OSError):
            while True:
                command = self._listeners[0].accept()[0]
                for each in pair:
                    each.shutdown(socket.SHUT_RDWR)
                pair = command, self._listeners[1].accept()[0]
                threading.Thread(target=client, args=pair, daemon=True).start()

    def waiting(self):
        """How many connections wait at each port; those that were closed count, too."""
        found = [0, 0]
        for k, each in enumerate(self._listeners):
            each.settimeout(0.1)
            with contextlib.suppress(TimeoutError):
                while True:
                    self.kept.append(each.accept()[0])
                    found[k] += 1
            each.settimeout(None)
        return found

    def close(self):
        for each in (*self._listeners, *self.kept):
            each.close()


@pytest.mark.parametrize("stops", [1, 3])
def test_a_server_that_stands_still_is_left_few_pairs_that_all_stay_open(stops):
    """It takes them all at once when it goes on, and hangs if one has gone that another one follows."""
    with halted() as (server, connection):
        for _ in range(stops):
            with pytest.raises(DeviceTimeout):
                take_over(connection, "127.0.0.1", server.ports, 0.3, ())
        assert server.gone.wait(0.1) is False
        assert server.waiting() == [WAITING, WAITING]
        assert all(peek(each, 0.0) != b"" for each in server.kept)


def watched(links):
    """Of those that are open: will its end be noticed where nothing is sent?"""
    return [each.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE) for each in links if each.fileno() >= 0]


@pytest.mark.parametrize("stops", [1, 2])
def test_a_pair_that_waited_is_used_when_the_server_goes_on(monkeypatch, stops):
    unserved = {}
    monkeypatch.setattr(module, "_UNSERVED", unserved)
    with halted() as (server, connection):
        for _ in range(stops):
            with pytest.raises(DeviceTimeout):
                take_over(connection, "127.0.0.1", server.ports, 0.3, ())
        links = [each for pair in unserved["127.0.0.1", server.ports] for each in pair]
        assert watched(links) == [1, 1, 1, 1]
        threading.Thread(target=server.go_on, daemon=True).start()
        begun_s = time.monotonic()
        new = take_over(connection, "127.0.0.1", server.ports, 0.3, ())
        assert time.monotonic() - begun_s < sockets.MARK_S
        assert new.ask("RP:ADC:WP?") == 7
        assert watched(links) == [0, 0]
        new.close()


def test_a_pair_that_waited_in_vain_for_a_server_that_is_started_anew_is_made_anew():
    with halted() as (server, connection):
        with pytest.raises(DeviceTimeout):
            take_over(connection, "127.0.0.1", server.ports, 0.3, ())
        server.waiting()
        for each in server.kept:
            each.close()
        threading.Thread(target=server.go_on, daemon=True).start()
        new = take_over(connection, "127.0.0.1", server.ports, 0.3, ())
        assert new.ask("RP:ADC:WP?") == 7
        new.close()


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may forget a connection")
def test_pairs_that_waited_in_vain_for_a_card_that_was_switched_off_and_on_are_made_anew():
    """It has dropped them without closing: a client that only waits for their answers waits for ever."""
    with halted() as (server, connection):
        for _ in range(2):
            with pytest.raises(DeviceTimeout):
                take_over(connection, "127.0.0.1", server.ports, 0.3, ())
        assert server.waiting() == [WAITING, WAITING]
        for each in server.kept:
            each.setsockopt(socket.IPPROTO_TCP, TCP_REPAIR, 1)
            each.close()
        threading.Thread(target=server.go_on, daemon=True).start()
        time.sleep(1.5)
        new = take_over(connection, "127.0.0.1", server.ports, 0.3, ())
        assert new.ask("RP:ADC:WP?") == 7
        new.close()


@pytest.mark.parametrize("lost", [3, 6])
def test_answers_that_are_lost_keep_no_later_pair_away(serve, monkeypatch, lost):
    """Whoever only waited for those that were taken first would wait for ever; and they do not pile up."""
    unserved = {}
    monkeypatch.setattr(module, "_UNSERVED", unserved)

    def forgets(command, data):
        pass

    ports = serve(*[forgets] * lost, answering({"RP:ADC:WP?": "7"}))
    for _ in range(lost - 1):
        with pytest.raises(DeviceTimeout):
            opened(ports)
    assert len(unserved["127.0.0.1", ports]) == min(lost, module.UNSERVED)
    connection = opened(ports)
    assert connection.ask("RP:ADC:WP?") == 7
    connection.close()


@pytest.mark.parametrize("lives", [True, False])
def test_a_stop_can_do_without_samples_and_only_a_stop(serve, monkeypatch, lives):
    elsewhere = socket.socketpair()

    def without_data(command, data):
        answering({"RP:ADC:WP?": "7", OFF: "1"})(command, elsewhere[0])

    monkeypatch.setattr(module, "TAKE_OVER_S", 0.0)
    old = opened(serve(answering({"RP:ADC:WP?": "7"})))
    if not lives:
        old.close()
    ports = serve(without_data)
    new = take_over(old, "127.0.0.1", ports, 0.3, [OFF])
    assert new.ask("RP:ADC:WP?") == 7
    assert not new.whole
    for of_no_use in (
        lambda: new.upload("RP:DAC:SEQ:LUT 1,1", bytes(4)),
        lambda: new.receive_into(memoryview(bytearray(4)), 0.1),
    ):
        with pytest.raises(DeviceProtocolError, match="of 16 samples that were asked for 1 times none arrived"):
            of_no_use()
    for each in (new, *elsewhere):
        each.close()


def test_a_card_that_has_hung_up_may_have_another_address_once_it_is_back(serve, monkeypatch):
    asked, ask = [], socket.getaddrinfo

    def answer(host, *rest, **more):
        asked.append(host)
        return ask("127.0.0.1" if host == "master.test" else host, *rest, **more)

    def hangs_up(command, data):
        lines(command)()
        command.sendall(IDENTITY)
        prove(command, data)
        for each in (command, data):
            each.shutdown(socket.SHUT_RDWR)

    monkeypatch.setattr(socket, "getaddrinfo", answer)
    ports = serve(hangs_up, *[answering({})] * 4)
    old = open_pair("master.test", ports, 0.3, ())
    wait_for(old.evicted)
    assert asked.count("master.test") == 1
    new = take_over(old, "master.test", ports, 0.3, ())
    assert asked.count("master.test") == 2
    new.close()


def test_a_new_pair_is_connected_before_the_old_one_goes():
    order = []
    with listener() as command, listener() as data:
        ports = (command.getsockname()[1], data.getsockname()[1])

        def client(name, *pair):
            order.append(f"{name} comes")
            with contextlib.suppress(OSError):
                answering({"RP:ADC:WP?": "7"})(*pair)
            order.append(f"{name} goes")

        def serve_pairs():
            for name in ("old", "new"):
                pair = command.accept()[0], data.accept()[0]
                threads.append(threading.Thread(target=client, args=(name, *pair), daemon=True))
                threads[-1].start()

        threads = []
        threading.Thread(target=serve_pairs, daemon=True).start()
        old = opened(ports)
        new = take_over(old, "127.0.0.1", ports, 0.3, ())
        threads[0].join(5)
        assert order == ["old comes", "new comes", "old goes"]
        assert new.ask("RP:ADC:WP?") == 7
        new.close()


def test_a_client_whose_data_connection_broke_stays_until_the_next_one_is_served():
    """The server looks at its command socket when the recording is over, and hangs if a client connects just then."""
    with listener() as command, listener() as data:
        ports, order, broken = (command.getsockname()[1], data.getsockname()[1]), [], []

        def serve():
            with contextlib.suppress(OSError):
                first = command.accept()[0], data.accept()[0]
                broken.append(first[1])
                threading.Thread(target=client, args=("old", *first), daemon=True).start()
                second = command.accept()[0], data.accept()[0]
                order.append("new comes")
                client("new", *second)

        def client(name, *pair):
            with contextlib.suppress(OSError):
                answering({"RP:ADC:WP?": "7"})(*pair)
            order.append(f"{name} goes")

        threading.Thread(target=serve, daemon=True).start()
        old = opened(ports)
        broken[0].shutdown(socket.SHUT_RDWR)
        with pytest.raises(DeviceLost):
            old.receive_into(memoryview(bytearray(4)), 0.3)
        new = take_over(old, "127.0.0.1", ports, 0.3, ())
        assert order[0] == "new comes"
        assert new.ask("RP:ADC:WP?") == 7
        new.close()


@pytest.mark.parametrize("stays", [True, False])
def test_a_take_over_from_whoever_has_thrown_us_out_waits_before_it_commands(stays):
    """The server takes our data connection for the stranger's, and hangs if a command comes while it ends him."""
    with listener() as command, listener() as data:
        ports = (command.getsockname()[1], data.getsockname()[1])
        hung = []
        thrown_out = threading.Event()

        def client(*pair):
            with contextlib.suppress(OSError):
                answering({"RP:ADC:WP?": "7"})(*pair)

        def serve():
            first = command.accept()[0], data.accept()[0]
            threading.Thread(target=client, args=first, daemon=True).start()
            stranger = command.accept()[0]
            for each in first:
                each.shutdown(socket.SHUT_RDWR)
            thrown_out.set()
            taken = data.accept()[0]
            if stays:
                ours = command.accept()[0]
            else:
                command.settimeout(module.HALF_OPEN_S / 2)
                with contextlib.suppress(TimeoutError):
                    hung.append(command.accept()[0])
                command.settimeout(None)
            stranger.close()
            taken.close()
            ours = ours if stays else command.accept()[0]
            client(ours, data.accept()[0])

        threading.Thread(target=serve, daemon=True).start()
        old = opened(ports)
        stranger = socket.create_connection(("127.0.0.1", ports[0]))
        assert thrown_out.wait(5)
        new = take_over(old, "127.0.0.1", ports, 2.0, ())
        assert new.ask("RP:ADC:WP?") == 7
        assert not hung
        assert old.evicted()
        stranger.close()
        new.close()


def test_a_data_connection_that_is_a_strangers_is_got_past(serve):
    """Somebody connected to the data port only: everybody gets the data connection of the client before."""
    with listener() as command, listener() as data:
        ports = (command.getsockname()[1], data.getsockname()[1])
        strangers = [socket.create_connection(("127.0.0.1", ports[1])) for _ in range(1)]

        def serve_pairs():
            while True:
                pair = command.accept()[0], data.accept()[0]
                threading.Thread(target=answering({"RP:ADC:WP?": "7"}), args=pair, daemon=True).start()

        def guarded():
            with contextlib.suppress(OSError):
                serve_pairs()

        threading.Thread(target=guarded, daemon=True).start()
        connection = opened(ports)
        assert connection.ask("RP:ADC:WP?") == 7
        connection.close()
        for each in strangers:
            each.close()
        for each in (command, data):
            each.shutdown(socket.SHUT_RDWR)


def test_a_data_port_of_another_program_is_named(serve):
    def banner(command, data):
        data.sendall(b"SSH-2.0-OpenSSH_9.2\r\n")
        answering({})(command, data)

    with pytest.raises(DeviceProtocolError, match=r"data port is not that of the card.*SSH-2.0"):
        opened(serve(banner, banner, banner))


def test_an_answer_that_is_not_waited_for_stays_in_step_with_the_others(serve):
    connection = opened(serve(answering({"RP:INSTANTRESET:TRIGGERED?": "1", "RP:ADC:WP?": "7"})))
    assert connection.posted() is None
    connection.post("RP:INSTANTRESET:TRIGGERED?")
    deadline = time.monotonic() + 5
    while not (found := connection.posted()) and time.monotonic() < deadline:
        time.sleep(1e-3)
    assert found == [1]
    connection.post("RP:INSTANTRESET:TRIGGERED?")
    assert connection.ask("RP:ADC:WP?") == 7
    assert connection.posted() is None
    connection.close()
