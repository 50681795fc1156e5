"""Cards, servers and links that go and come back: one clear error, and the next shot is whole without a hand."""

from __future__ import annotations

import time

import pytest

from drivers.conformance.io_card import collect
from drivers.conformance.timelines import short_shot
from drivers.errors import DeviceError, OutputsUnconfirmed, ShotRefused
from drivers.io_card import CardState
from drivers.outputs_off import switch_outputs_off
from drivers.red_pitaya import board as module
from drivers.red_pitaya.pairing import take_over
from tests.kit.emulated_lab import lines_at
from tests.kit.host_process import Host


def whole_shot(card):
    timeline = short_shot(card.capabilities(), rx_s=0.03)
    return sum(c.volts.shape[1] for c in collect(card, timeline, 5000)) == timeline.total_samples


@pytest.fixture
def own(lab_of_its_own):
    """A lab of the test's own and a card on it."""
    lab = lab_of_its_own()
    platform = lab.platform()
    yield lab, platform.card
    platform.close()
    assert lab.violations() == ()


def test_one_new_connection_after_the_other_never_closes_before_it_connects(own, monkeypatch):
    """A stop opens new connections to both cards and fails for one; the next stop connects the other one once more.

    A client that closes that card's connection and then connects hangs the real server one time in eight.
    """
    _, card = own

    def watched(old, *rest):
        """The connection that the server serves now is open until the next one is there."""
        old.synchronise()
        return take_over(old, *rest)

    monkeypatch.setattr(module, "take_over", watched)
    for board in card.boards:
        board.replace()
        board.replace()
        board.settle()
    assert whole_shot(card)


@pytest.mark.parametrize("board", [0, 1])
@pytest.mark.parametrize("state", [CardState.PROGRAMMED, CardState.ARMED, CardState.RUNNING])
def test_a_server_that_died_is_named_and_once_it_is_back_the_next_shot_is_whole(own, board, state):
    lab, card = own
    card.program(short_shot(card.capabilities(), rx_s=1.0))
    if state is not CardState.PROGRAMMED:
        card.arm()
    if state is CardState.RUNNING:
        card.trigger()
        card.read(1000)
    lab.kill_server(board)
    where = str(lab.emulator.endpoints()["io_cards"][board]["data_port"])
    with pytest.raises(DeviceError, match=f"(?s)could not be confirmed off.*{where}.*switch the amplifier's mains off"):
        card.stop()
    lab.start_server(board)
    card.stop()
    assert lab.control("outputs")["off"]
    assert whole_shot(card)


@pytest.mark.parametrize(
    ("board", "state"), [(0, CardState.RUNNING), pytest.param(1, CardState.ARMED, marks=pytest.mark.long)]
)
@pytest.mark.long
def test_a_link_that_was_cut_is_named_and_once_it_is_back_the_next_shot_is_whole(lab_of_its_own, board, state):
    lab = lab_of_its_own()
    platform = lab.platform("io_card.reply_timeout_s=1.0", "io_card.sample_timeout_s=1.0")
    card = platform.card
    card.program(short_shot(card.capabilities(), rx_s=0.3))
    card.arm()
    if state is CardState.RUNNING:
        card.trigger()
        card.read(1000)
    device = f"io_card_{board}"
    for kind, stream in (("deaf_link", "command"), ("one_way_link", "command"), ("one_way_link", "data")):
        lab.control("wire_fault", kind=kind, device=device, stream=stream)
    where = str(lab.emulator.endpoints()["io_cards"][board]["command_port"])
    with pytest.raises(DeviceError, match=f"(?s)could not be confirmed off.*{where}.*switch the amplifier's mains off"):
        card.stop()
    assert lab.control("outputs")["off"]  # the sequence has ended by itself
    lab.control("clear_faults")
    card.stop()
    assert whole_shot(card)
    platform.close()
    assert lab.violations() == ()


@pytest.mark.parametrize("server_too", [False, pytest.param(True, marks=pytest.mark.long)])
def test_a_client_that_was_killed_leaves_outputs_off_and_the_next_one_shoots(lab_of_its_own, server_too):
    lab = lab_of_its_own()
    host = Host(lab.endpoints, ("limits.max_tx_duty=0.9",))
    host.ask("shot")
    while not lab.emulator.world.is_running():
        time.sleep(1e-3)
    host.kill()
    if server_too:
        lab.kill_server(0)
        lab.start_server(0)
    time.sleep(0.6)  # the shot is over
    assert not lab.control("outputs")["playing"]
    assert not lab.control("outputs")["pa_gate"]
    assert max(span.stop_s - span.start_s for span in lab.emulator.world.power_log()) <= host.gate_s + 1e-3
    platform = lab.platform()
    assert whole_shot(platform.card)
    platform.close()
    assert lab.violations() == ()


def interrupted(lab, card, *, rx_s):
    """A shot in which the trigger's cable is open for a moment, some time after TX."""
    timeline = short_shot(card.capabilities(), rx_s=rx_s)
    card.program(timeline)
    card.arm()
    card.trigger()
    card.read(timeline.rx_start)
    for joined in (False, True):
        lab.control("trigger_cable", joined=joined)
    card.read(timeline.total_samples - timeline.rx_start)


def test_a_slave_whose_trigger_was_gone_for_a_moment_costs_the_shot(own):
    """Its samples are those of a later time from there on, and no record tells."""
    lab, card = own
    with pytest.raises(ShotRefused, match="did not record together"):
        interrupted(lab, card, rx_s=0.5)
    card.stop()
    assert whole_shot(card)


def test_a_gate_on_a_slave_is_lowered_although_the_master_is_dead(lab_of_its_own):
    """By the process that opens the cards after a daemon was killed: the amplifier's guard."""
    emulated, lines = lines_at("1 DIO7_P", "1 DIO6_P")
    lab = lab_of_its_own(*emulated)
    host = Host(
        lab.endpoints, (*lines, "io_card.chunk_samples=320", "io_card.pin_delay_s=0.2", "limits.max_tx_duty=0.9")
    )
    host.ask("shot")
    until_s = time.monotonic() + 5
    while not lab.control("outputs")["pa_gate"]:
        assert time.monotonic() < until_s
    host.kill()
    lab.kill_server(0)
    assert lab.control("outputs")["pa_gate"]
    with pytest.raises(OutputsUnconfirmed, match="io_card"):
        switch_outputs_off(lab.file(*lines).section)
    assert not lab.control("outputs")["pa_gate"]
