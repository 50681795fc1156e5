"""What goes wrong on the card's wire ends in its own error, with outputs off, and the next shot is whole again."""

from __future__ import annotations

import socket
import threading
import time

import numpy as np
import pytest

from drivers.conformance.io_card import collect
from drivers.conformance.timelines import short_shot
from drivers.errors import DeviceDenied, DeviceError, DeviceFault, DeviceLost, DeviceProtocolError, DeviceTimeout
from drivers.inventory import find_devices
from drivers.io_card import CardState
from drivers.registry import build_platform
from platform_daemon.core.hardware.shot import run_shot
from platform_daemon.core.settings import load_sequence
from sequences.compiler import TransmitSide, compile_shot
from tests.kit.emulated_lab import intruder, watched_shot


@pytest.fixture
def own(lab_of_its_own):
    """A lab of the test's own and a platform on it."""
    lab = lab_of_its_own()
    platform = lab.platform()
    yield lab, platform
    platform.close()
    assert lab.violations() == ()


def whole_shot(card):
    timeline = short_shot(card.capabilities())
    return sum(c.volts.shape[1] for c in collect(card, timeline, 5000)) == timeline.total_samples


def rest_of_shot(card):
    while card.state() is CardState.RUNNING:
        card.read(1000)


@pytest.mark.parametrize("board", [0, 1])
def test_a_card_that_another_client_takes_in_the_middle_of_a_shot_is_lost_and_found(own, board):
    lab, platform = own
    card = platform.card
    card.program(short_shot(card.capabilities(), rx_s=2.0))
    card.arm()
    card.trigger()
    card.read(1000)
    other = intruder(lab, board)
    with pytest.raises(DeviceError):
        rest_of_shot(card)
    platform.outputs_off()
    assert card.state() is CardState.IDLE
    assert whole_shot(card)
    other.close()


def test_a_card_that_another_client_takes_between_shots_is_noticed(own):
    lab, platform = own
    other = intruder(lab)
    with pytest.raises(DeviceLost, match="another client"):
        platform.card.identity()
    with pytest.raises(DeviceLost, match="POST /stop"):
        platform.card.program(short_shot(platform.card.capabilities()))
    platform.outputs_off()
    assert whole_shot(platform.card)
    other.close()


@pytest.mark.long
def test_a_card_whose_samples_do_not_arrive_is_off_all_the_same_and_plays_nothing_until_they_do(own):
    lab, platform = own
    card = platform.card
    timeline = short_shot(card.capabilities())
    lab.control("wire_fault", kind="one_way_link", device="io_card_0", stream="data")
    with pytest.raises(DeviceTimeout, match="no samples arrive"):
        list(collect(card, timeline, 5000))
    platform.outputs_off()
    with pytest.raises(DeviceProtocolError, match=r"of 16 samples.*none arrived"):
        card.program(timeline)
    lab.control("repair")
    platform.outputs_off()
    assert whole_shot(card)


def test_a_reconnect_does_not_resume_output(own):
    lab, platform = own
    card = platform.card
    card.program(short_shot(card.capabilities(), rx_s=2.0))
    card.arm()
    card.trigger()
    card.read(100)
    card.stop()
    before = lab.control("outputs")
    time.sleep(0.1)
    assert lab.control("outputs") == before
    assert card.state() is CardState.IDLE
    assert card.boards[0].ask("RP:MODE?", "RP:TRIGGER?") == ["CONFIGURATION", "OFF"]


def test_a_second_daemon_on_this_computer_is_refused_and_the_first_goes_on(own):
    lab, platform = own
    with pytest.raises(DeviceDenied, match="another daemon"):
        lab.platform()
    assert whole_shot(platform.card)


def knock(lab):
    """A stranger connects to the data port and goes, as a port scan does."""
    at = lab.emulator.endpoints()["io_cards"][0]
    socket.create_connection((at["host"], at["data_port"]), timeout=2).close()


def test_a_stranger_who_was_at_the_data_port_before_costs_nothing(lab_of_its_own):
    lab = lab_of_its_own()
    knock(lab)
    platform = lab.platform("io_card.reply_timeout_s=1.0")
    assert whole_shot(platform.card)
    platform.close()


def test_a_stranger_at_the_data_port_costs_nothing_when_the_card_is_connected_anew(lab_of_its_own):
    lab = lab_of_its_own()
    platform = lab.platform("io_card.reply_timeout_s=1.0", "io_card.sample_timeout_s=1.0")
    knock(lab)
    platform.card.program(short_shot(platform.card.capabilities()))
    platform.card.arm()
    platform.outputs_off()  # by a new connection
    assert whole_shot(platform.card)
    platform.close()


def test_strangers_that_fill_the_queue_of_the_data_port_keep_nobody_out(lab_of_its_own):
    lab = lab_of_its_own()
    for _ in range(2):
        knock(lab)
    platform = lab.platform()
    assert whole_shot(platform.card)
    platform.close()


def test_a_table_that_a_client_before_has_uploaded_and_not_set_is_not_played(lab_of_its_own):
    """Only SEQ:SET takes it away: ours was played after gate and receiver at once, and passed for a whole shot."""
    lab = lab_of_its_own()
    other = intruder(lab)
    other.ask_all(["RP:MODE CONFIGURATION", "RP:DAC:SEQ:CHAN 4"])
    other.upload("RP:DAC:SEQ:LUT:UP 400,1", np.tile(np.array([0, 0, 1.8, 1.8], "<f4"), 400).tobytes())
    platform = lab.platform()
    shot = plan(lab, platform)
    assert watched_shot(platform, shot).reason is None
    platform.close()
    other.close()
    assert lab.violations() == ()


def test_another_version_of_the_server_is_refused(lab_of_its_own):
    boards = '{inputs=["x","y"], outputs=["x","y"], server_version=10}'
    lab = lab_of_its_own(f"io_cards.boards=[{boards}]")
    master = (
        '{host="${io_cards.0.host}", command_port="${io_cards.0.command_port}", data_port="${io_cards.0.data_port}"}'
    )
    with pytest.raises(DeviceProtocolError, match="server version 10, not 11"):
        lab.platform(f"io_card.boards=[{master}]")


def test_inputs_that_were_never_calibrated_are_said_or_refused(lab_of_its_own):
    boards = '{inputs=["x","y"], outputs=["x","y"], calibration_flags=0}'
    lab = lab_of_its_own(f"io_cards.boards=[{boards}]")
    master = (
        '{host="${io_cards.0.host}", command_port="${io_cards.0.command_port}", data_port="${io_cards.0.data_port}"}'
    )
    one = f"io_card.boards=[{master}]"
    with pytest.raises(DeviceProtocolError, match="never calibrated"):
        lab.platform(one, "io_card.require_calibration=true")
    platform = lab.platform(one)
    assert "not calibrated" in platform.card.identity().firmware
    platform.close()


def test_the_scale_in_the_cards_memory_turns_counts_into_volts(lab_of_its_own):
    scale = "[6.1e-4, 3.0517578125e-05]"
    boards = f'{{inputs=["x","y"], outputs=["x","y"], adc_scale_v={scale}, adc_offset_v=[0.01, 0.0]}}'
    lab = lab_of_its_own(f"io_cards.boards=[{boards}]", "world.noise.scale=0.0")
    master = (
        '{host="${io_cards.0.host}", command_port="${io_cards.0.command_port}", data_port="${io_cards.0.data_port}"}'
    )
    platform = lab.platform(f"io_card.boards=[{master}]")
    chunks = collect(platform.card, short_shot(platform.card.capabilities(), bursts=False), 100_000)
    assert abs(float(chunks[0].volts[0, 100:400].mean())) < 7e-4  # the offset is taken off, to half a count
    platform.close()


@pytest.mark.parametrize(
    ("kind", "reason"),
    [("overwritten", "overwritten"), ("corrupted", "corrupted"), ("lost_steps", "lost_steps")],
)
def test_a_flag_of_the_card_refuses_the_shot(own, kind, reason):
    lab, platform = own
    lab.emulator.world.faults.inject(kind, lab.emulator.world.shots + 1)
    raw = run_shot(platform, plan(lab, platform))
    assert reason in (raw.reason or "")
    assert watched_shot(platform, plan(lab, platform)).reason is None


@pytest.mark.parametrize("board", [0, 1])
def test_the_emergency_input_of_either_card_refuses_the_shot(own, board):
    lab, platform = own
    card = platform.card
    timeline = short_shot(card.capabilities())
    card.program(timeline)
    card.arm()
    card.trigger()
    card.read(100)
    lab.control("instant_reset", board=board, level=True)
    with pytest.raises(DeviceFault, match="emergency"):
        rest_of_shot(card)
    lab.control("instant_reset", board=board, level=False)
    card.stop()
    assert card.state() is CardState.IDLE
    assert whole_shot(card)


def test_a_stop_in_every_phase_of_a_real_shot_leaves_everything_off(own):
    lab, platform = own
    shot = plan(lab, platform)
    run_shot(platform, shot)
    for delay_s in (0.01, 0.03, 0.06, 0.2):
        cancelled = threading.Event()

        def stop(cancelled=cancelled):
            cancelled.set()
            platform.outputs_off()

        timer = threading.Timer(delay_s, stop)
        timer.start()
        with pytest.raises(Exception, match=r"^$"):  # Cancelled
            run_shot(platform, shot, cancelled=cancelled.is_set)
        timer.join()
        assert platform.card.state() is CardState.IDLE
        assert not platform.amplifier.status().can_put_out_power
    assert watched_shot(platform, shot).reason is None


def plan(lab, platform):
    limits = lab.file().limits
    side = TransmitSide(platform.transmit, platform.card.capabilities(), platform.switch.timing(), limits)
    return compile_shot(load_sequence("jewel").model_copy(update={"rx_s": 0.3}), side)


def test_a_missing_device_is_a_row_and_the_others_are_there(lab_of_its_own):
    lab = lab_of_its_own()
    file = lab.file('lna.port="/dev/no-such-port"', "power_amplifier.product_id=1")
    found = {r.device: r for r in find_devices(file.section)}
    assert found["io_card"].error is None
    assert found["tx_rx_switch"].state["position"] == "transmit"
    assert "no such serial port" in str(found["lna"].error)
    assert "no such USB device" in str(found["power_amplifier"].error)
    with pytest.raises(DeviceError):
        build_platform(file.section)
    assert all(r.error is None for r in find_devices(lab.file().section))


def test_a_world_that_runs_faster_than_the_hosts_clock_makes_the_same_shots(lab_of_its_own):
    lab = lab_of_its_own("speed=3.0")
    platform = lab.platform()
    limits = lab.file().limits
    side = TransmitSide(platform.transmit, platform.card.capabilities(), platform.switch.timing(), limits)
    shot = compile_shot(load_sequence("jewel").model_copy(update={"rx_s": 3.0}), side)
    try:
        for _ in range(2):
            raw = run_shot(platform, shot)
            assert raw.reason is None
            assert raw.volts.shape[1] == shot.timeline.total_samples
    finally:
        platform.close()
    assert lab.violations() == ()
