"""Shots from the cards' memories, gate and receiver on DIO pins: the watchdog ends what the cards play."""

from __future__ import annotations

import time

import pytest

from drivers.conformance.timelines import collect, short_shot
from drivers.errors import OutputsUnconfirmed
from drivers.outputs_off import switch_outputs_off
from drivers.red_pitaya.connection import Connection
from tests.kit.emulated_lab import REPLAY, lines_at, wired
from tests.kit.host_process import Host

EMULATED, LINES = lines_at("0 DIO7_P", "0 DIO6_P")
OPTIONS = (*REPLAY, *LINES, "io_card.chunk_samples=320", "io_card.pin_delay_s=0.2")  # others work beside the tests


@pytest.fixture
def own(lab_of_its_own):
    """A lab of the test's own, with both wires, and a platform on it."""
    lab = lab_of_its_own(wired(), *EMULATED)
    platform = lab.platform(*OPTIONS)
    yield lab, platform
    assert lab.violations() == ()
    for board in (0, 1):
        lab.emulator.kill_server(board)


def test_shots_are_played_from_the_memory_and_nothing_is_written_again(own, monkeypatch):
    _, platform = own
    card, uploads = platform.card, []
    upload = Connection.upload
    monkeypatch.setattr(Connection, "upload", lambda self, *a: (uploads.append(a[0]), upload(self, *a)))
    timeline = short_shot(card.capabilities())
    for _ in range(4):
        assert collect(card, timeline, 5000)
        card.stop()  # as the daemon does after every shot
        assert all(board.occupied for board in card.boards)
    assert len(uploads) == 6  # table, enable and resync bits of two cards


@pytest.mark.long
def test_a_shot_without_power_may_last_longer_than_the_memory(own):
    """Nothing is in the memories then that could be played again."""
    _, platform = own
    can = platform.card.capabilities()
    blank = short_shot(can, rx_s=2.2, bursts=False)
    assert sum(c.volts.shape[1] for c in collect(platform.card, blank, 5000)) == blank.total_samples


@pytest.mark.long
@pytest.mark.parametrize("moment", ["tx", "rx"])
def test_servers_that_are_killed_leave_outputs_that_stay_silent(own, moment):
    """A pin keeps its level then, as it does without the option; the amplifier has a link of its own for that."""
    lab, platform = own
    card, timeline = platform.card, short_shot(platform.card.capabilities())
    collect(card, timeline, 5000)
    card.program(timeline)
    card.arm()
    card.trigger()
    if moment == "rx":
        card.read(timeline.rx_start + 400)
    for board in (0, 1):
        lab.kill_server(board)
    time.sleep(timeline.tx_samples / timeline.clock.rate_hz + 0.1)
    until_s = time.monotonic() + 2.5 + timeline.duration_s
    while time.monotonic() < until_s:
        assert not lab.control("outputs")["playing"]
        time.sleep(5e-3)
    assert all(board.emergency.latched for board in lab.emulator.cards.boards)


def test_a_gate_on_a_slave_is_lowered_although_the_master_is_dead(lab_of_its_own):
    """By whoever opens the cards after a daemon that was killed: the amplifier's guard does."""
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
