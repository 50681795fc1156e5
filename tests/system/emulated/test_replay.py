"""Shots that stay in the cards' memories, with the wire that ends them: `io_card.replay_watchdog`."""

from __future__ import annotations

import time

import numpy as np
import pytest

from drivers.conformance.timelines import collect, short_shot, steps
from drivers.errors import ConfigError, DeviceError, DeviceFault, SequenceRejected, ShotRefused
from drivers.red_pitaya.connection import Connection
from drivers.timeline import Burst, DigitalLine, LineLevel, Timeline
from platform_daemon.engine.shot import run_shot
from platform_daemon.settings import load_sequence
from sequences.compiler import TransmitSide, compile_shot
from tests.kit.emulated_lab import REPLAY, WIRE, wired
from tests.kit.host_process import GOOD, Host

DEAD_S = 0.03
RING_S = 8192 * 16 * 2048 / 125e6


def fine_shot(can):
    """As `short_shot`, on the finest grid: the memory would be played again after 2.1 s."""
    shot = short_shot(can)
    total = shot.total_samples + 16
    tx, connect = shot.tx_samples, next(e.start_sample for e in shot.lines if e.line is DigitalLine.RX_CONNECT) + 16
    lines = (LineLevel(DigitalLine.PA_GATE, 0, tx), LineLevel(DigitalLine.RX_CONNECT, connect, total))
    bursts = tuple(Burst(b.output, 0, tx, b.frequency_hz, 0.1) for b in shot.bursts)
    return Timeline(can.clock, tx, shot.switch_samples, total - tx - shot.switch_samples, bursts, lines)


@pytest.fixture
def own(lab_of_its_own):
    """A lab of the test's own, with both wires, and a platform on it."""
    lab = lab_of_its_own(wired())
    platform = lab.platform(*REPLAY)
    yield lab, platform
    assert lab.violations() == ()
    for board in (0, 1):
        lab.emulator.kill_server(board)


@pytest.fixture
def playing(own):
    """The same, in the middle of TX of a shot that was played before."""
    lab, platform = own
    timeline = fine_shot(platform.card.capabilities())
    collect(platform.card, timeline, 5000)
    platform.card.program(timeline)
    platform.card.arm()
    platform.card.trigger()
    return lab, platform.card, timeline


def gates(lab, seconds):
    """How often the gate rose or an output began to play within so many seconds."""
    rises, was, until_s = 0, True, time.monotonic() + seconds
    while time.monotonic() < until_s:
        now = lab.control("outputs")
        on = now["pa_gate"] or bool(now["playing"])
        rises, was = rises + (on and not was), on
        time.sleep(2e-3)
    return rises


# --- shot after shot


def test_a_shot_that_is_in_the_memory_is_played_again_at_once_and_without_an_upload(own, monkeypatch):
    _, platform = own
    card, uploads, dead = platform.card, [], []
    timeline = short_shot(card.capabilities(), rx_s=0.03)
    upload = Connection.upload
    monkeypatch.setattr(Connection, "upload", lambda self, *a: (uploads.append(a[0]), upload(self, *a)))
    for _ in range(12):
        card.program(timeline)
        card.arm()
        card.trigger()
        begun_s = time.monotonic()
        volts = card.read(timeline.total_samples).volts
        dead.append(-time.monotonic())
        assert np.all(np.isfinite(volts))
        if len(dead) > 1:
            dead[-2] += begun_s
        card.stop()  # as the daemon does after every shot
    assert len(uploads) == 6  # table, enable and resync bits of two cards
    assert min(dead[:-1]) < DEAD_S  # with an upload the quickest takes 0.07 s, on however idle a machine


def test_the_daemons_shots_are_played_from_the_memory(own):
    lab, platform = own
    can, file = platform.card.capabilities(), lab.file(*REPLAY)
    jewel = load_sequence("jewel").model_copy(update={"rx_s": 0.5})
    plan = compile_shot(jewel, TransmitSide(platform.transmit, can, platform.switch.timing(), file.limits))
    held = []
    for _ in range(3):
        assert run_shot(platform, plan).reason is None
        held.append(all(board.occupied for board in platform.card.boards))
    assert held == [True] * 3


def test_a_second_stop_empties_the_memory(own):
    _, platform = own
    collect(platform.card, short_shot(platform.card.capabilities()), 5000)
    platform.card.stop()
    assert all(board.occupied for board in platform.card.boards)
    platform.card.stop()
    assert not any(board.occupied for board in platform.card.boards)


def test_a_shot_that_is_longer_than_the_memory_is_refused_with_the_way_out(own):
    _, platform = own
    can = platform.card.capabilities()
    shot = fine_shot(can)
    total = steps(2.0 * can.clock.rate_hz, can) // 32 * 32 + 16
    long = Timeline(can.clock, shot.tx_samples, shot.switch_samples, total, shot.bursts, shot.lines)
    connect = LineLevel(DigitalLine.RX_CONNECT, shot.lines[1].start_sample, total)
    long = Timeline(can.clock, shot.tx_samples, shot.switch_samples, total, shot.bursts, (shot.lines[0], connect))
    with pytest.raises(SequenceRejected, match=r"7372 steps.*coarser grid.*replay_watchdog = false"):
        platform.card.program(long)


# --- who vanishes


@pytest.mark.long
@pytest.mark.parametrize("moment", ["tx", "rx"])
def test_servers_that_are_killed_leave_a_card_that_stays_silent(playing, moment):
    lab, _, timeline = playing
    if moment == "rx":
        time.sleep(timeline.rx_start / timeline.clock.rate_hz + 0.02)
    for board in (0, 1):
        lab.kill_server(board)
    assert gates(lab, timeline.duration_s + 2.5 * RING_S) == 0
    assert all(board.emergency.latched for board in lab.emulator.cards.boards)


@pytest.mark.long
def test_without_its_wire_the_memory_would_be_played_again(playing):
    """What the wire is there for; and that these tests would see it."""
    lab, _, timeline = playing
    for board in (0, 1):
        lab.control("wire", board=board, pins=None)
        lab.kill_server(board)
    assert gates(lab, timeline.duration_s + 1.5 * RING_S) >= 1


@pytest.mark.long
def test_a_link_that_is_cut_leaves_a_card_that_stays_silent(playing):
    lab, card, timeline = playing
    lab.cut_links()
    assert gates(lab, timeline.duration_s + 2.5 * RING_S) == 0
    lab.control("clear_faults")
    card.stop()
    assert collect(card, timeline, 5000)


@pytest.mark.long
@pytest.mark.parametrize("moment", ["tx", "rx"])
def test_a_host_that_is_killed_leaves_a_card_that_stays_silent(lab_of_its_own, moment):
    lab = lab_of_its_own(wired())
    host = Host(lab.endpoints, (*REPLAY, "limits.max_tx_duty=0.9"))
    host.ask("shot")
    assert host.answer()[0] == GOOD
    before = len(lab.control("power_log"))
    host.ask("shot")
    until_s = time.monotonic() + 5
    while not lab.control("outputs")["pa_gate"]:
        assert time.monotonic() < until_s
    time.sleep(0.01 if moment == "tx" else host.connect_s + 0.02)
    host.kill()
    time.sleep(1.0)
    assert gates(lab, 2.5 * RING_S) == 0
    assert len(lab.control("power_log")) <= before + 1
    assert lab.violations() == ()


def test_a_server_that_was_restarted_is_noticed_and_after_a_stop_the_next_shot_is_whole(own):
    lab, platform = own
    card, timeline = platform.card, short_shot(platform.card.capabilities())
    collect(card, timeline, 5000)
    lab.kill_server(1)
    lab.start_server(1)
    with pytest.raises(DeviceError, match=r"gone|no connection"):
        collect(card, timeline, 5000)
    card.stop()
    assert collect(card, timeline, 5000)


def test_a_host_that_is_late_for_the_end_of_the_shot_is_told_so(playing):
    _, card, timeline = playing
    time.sleep(timeline.duration_s + 0.7)
    with pytest.raises(ShotRefused, match="too late for the end of the shot"):
        card.read(timeline.total_samples)
    card.stop()
    assert collect(card, timeline, 5000)


# --- the wire


@pytest.mark.parametrize("board", [0, 1])
def test_a_wire_that_came_off_is_named_before_the_next_shot(own, board):
    lab, platform = own
    card, timeline = platform.card, short_shot(platform.card.capabilities())
    collect(card, timeline, 5000)
    lab.control("wire", board=board, pins=None)
    port = str(lab.emulator.endpoints()["io_cards"][board]["command_port"])
    card.program(timeline)
    with pytest.raises(DeviceFault, match=f"{port}.*wire from DIO4_N to DIO3_P is missing.*connect DIO4_N to DIO3_P"):
        card.arm()
    card.stop()
    lab.control("wire", board=board, pins=WIRE)
    assert collect(card, timeline, 5000)


@pytest.mark.parametrize(
    ("wires", "complaint"),
    [
        ((WIRE, None), "is missing.*no wire, or one to another pin"),
        ((("DIO3_N", "DIO3_P"), WIRE), "is missing"),
        ((WIRE, ("DIO4_N", "DIO3_N")), "is missing.*goes from DIO4_N to DIO3_N"),
    ],
)
def test_a_wire_that_is_wrong_is_named_before_anything_is_energised(lab_of_its_own, wires, complaint):
    lab = lab_of_its_own(wired(*wires))
    wrong = next(k for k, wire in enumerate(wires) if wire != WIRE)
    port = str(lab.emulator.endpoints()["io_cards"][wrong]["command_port"])
    with pytest.raises(DeviceFault, match=f"{port}.*{complaint}.*Remedy"):
        lab.platform(*REPLAY)
    assert lab.control("power_log") == []


def test_an_emergency_input_that_is_held_is_named_before_anything_is_energised(lab_of_its_own):
    lab = lab_of_its_own(wired())
    lab.control("instant_reset", board=1, level=True)
    with pytest.raises(DeviceFault, match=r"keeps the outputs off.*DIO3_P is high before"):
        lab.platform(*REPLAY)


def test_pins_that_the_watchdog_needs_are_refused(lab_of_its_own):
    lab = lab_of_its_own(wired(), 'amplifier.kind="line"')
    for pin in ("DIO4_N", "DIO3_N"):
        with pytest.raises(ConfigError, match=f"{pin} cannot be used with io_card.replay_watchdog"):
            lab.platform(*REPLAY, f'power_amplifier={{backend="red_pitaya", enable={{board=1, pin="{pin}"}}}}')
