"""Which wirings are allowed, and what is proved of them before the first shot."""

from __future__ import annotations

import threading
import time

import pytest

from drivers.conformance.io_card import collect
from drivers.conformance.timelines import short_shot
from drivers.errors import ConfigError, DeviceFault, DeviceTimeout, ShotRefused
from drivers.red_pitaya.card import RedPitayaCard
from drivers.red_pitaya.lines import PinLines
from drivers.red_pitaya.sequence import RING_STEPS
from drivers.wiring_proof import TRIES
from sim_backend.emulators.io_card.daq_server import left_alone
from tests.kit.emulated_lab import lines_at

PROVE = "io_card.prove_wiring=true"


@pytest.mark.parametrize(("gate", "receiver"), [("AO0", "DIO6_P"), ("DIO7_P", "AO1")])
def test_gate_and_receiver_timed_by_different_clocks_are_refused_with_the_reason(lab, gate, receiver):
    with pytest.raises(ConfigError, match=r"different clocks.*live amplifier.*both on"):
        lab.platform(f'io_card.lines.pa_gate={{pin="{gate}"}}', f'io_card.lines.rx_connect={{pin="{receiver}"}}')


def test_a_switch_without_read_back_must_be_declared_and_says_so(lab):
    switch = 'tx_rx_switch={backend="red_pitaya", dead_time_s=3e-3, bounce_s=1e-3, settle_s=4e-3'
    with pytest.raises(ConfigError, match="no_readback = true"):
        lab.platform(switch + "}")
    with pytest.raises(ConfigError, match="no_readback = true"):
        lab.platform(switch + ', no_readback=true, readback={pin="DIO5_N"}}')
    platform = lab.platform(switch + ", no_readback=true}")
    assert platform.switch.identity().firmware == "no read-back"
    platform.close()


def test_a_line_on_ao1_is_proved_before_the_first_shot(lab_of_its_own):
    lab = lab_of_its_own()
    platform = lab.platform(PROVE)
    assert not lab.control("outputs")["amplifier_live"]
    assert sum(c.volts.shape[1] for c in collect(platform.card, short_shot(platform.card.capabilities()), 5000))
    platform.close()
    assert lab.violations() == ()


def test_an_image_that_leaves_ao1_off_is_named(lab_of_its_own):
    boards = '{inputs=["x","y"], outputs=["x","y"], slow_outputs=1}, {inputs=["z",""], outputs=["z",""]}'
    lab = lab_of_its_own(f"io_cards.boards=[{boards}]")
    with pytest.raises(DeviceFault, match=r"does not follow the card's line.*0\.11\.1 drive AO0 only"):
        lab.platform(PROVE)


@pytest.mark.parametrize("times", [1, 10])
def test_a_computer_too_late_to_see_the_switch_tries_again_and_blames_no_image(lab_of_its_own, monkeypatch, times):
    lab, late, trigger = lab_of_its_own(), [], RedPitayaCard.trigger

    def slow(card):
        trigger(card)
        late.append(True)
        time.sleep(0.4 if len(late) <= times else 0.0)

    monkeypatch.setattr(RedPitayaCard, "trigger", slow)
    if times > TRIES:
        with pytest.raises(DeviceTimeout, match="too late to see the switch"):
            lab.platform(PROVE)
    else:
        lab.platform(PROVE).close()
    assert len(late) == min(times + 1, TRIES)
    assert lab.violations() == ()


def test_a_gate_where_it_cannot_be_proved_is_refused(lab):
    with pytest.raises(ConfigError, match="put it on AO0"):
        lab.platform(PROVE, 'io_card.lines.pa_gate={pin="AO2"}')


def test_a_second_master_is_found_before_anything_is_energised(lab_of_its_own):
    lab = lab_of_its_own('io_cards.trigger_wire="dio"')  # nothing reaches the second card over the clock cable
    with pytest.raises(DeviceTimeout, match="trigger did not reach the board"):
        lab.platform(PROVE)
    assert lab.control("power_log") == []


def test_a_host_too_slow_for_lines_on_pins_is_told_before_power(lab_of_its_own):
    lab = lab_of_its_own('io_cards.pa_gate={output="DIO7_P"}', 'io_cards.rx_connect={output="DIO6_P"}')
    pins = 'io_card.lines.pa_gate={pin="DIO7_P"}', 'io_card.lines.rx_connect={pin="DIO6_P"}'
    platform = lab.platform(*pins, "io_card.pin_delay_s=0.004")
    platform.card.program(short_shot(platform.card.capabilities()))
    platform.card.arm()
    with pytest.raises(DeviceTimeout, match=r"line on a DIO pin would be .* late"):
        platform.card.trigger()
    assert not lab.control("outputs")["pa_gate"]
    platform.close()


def test_a_dead_card_does_not_keep_the_amplifier_live(lab_of_its_own):
    lab = lab_of_its_own()
    platform = lab.platform("io_card.reply_timeout_s=1.0")
    platform.card.program(short_shot(platform.card.capabilities()))
    platform.card.arm()
    platform.amplifier.enable()
    platform.amplifier.unmute()
    power = lab.emulator.world.power
    assert power.enabled
    lab.control("wire_fault", kind="timeout", device="io_card_0")
    thread = threading.Thread(target=platform.outputs_off)
    begun_s = time.monotonic()
    thread.start()
    while power.enabled and time.monotonic() < begun_s + 5:
        time.sleep(1e-3)
    assert time.monotonic() - begun_s < 1.0
    assert thread.is_alive()  # the card has not answered yet
    thread.join(60)
    lab.control("clear_faults")
    platform.close()


def test_a_card_that_falls_silent_in_tx_is_given_up_before_its_memory_raises_the_gate_again(lab_of_its_own):
    """A server that hangs refills no more: one round after the trigger gate and sines rise, and the receiver of a card
    that is well is connected then.  The patience of the shipped table is longer than a round."""
    emulator, overrides = lines_at("0 AO0", "1 AO0")
    lab = lab_of_its_own(*emulator)
    platform = lab.platform(*overrides)
    can = platform.card.capabilities()
    timeline = short_shot(can, rx_s=3.0)
    platform.card.program(timeline)
    platform.card.arm()
    platform.amplifier.enable()
    platform.card.trigger()
    triggered_s = time.monotonic()
    round_s = RING_STEPS * platform.card.boards[0].table.step_samples / can.clock.rate_hz
    assert round_s < platform.card.boards[0].table.sample_timeout_s
    for stream in ("command", "data"):
        lab.control("wire_fault", kind="one_way_link", device="io_card_0", stream=stream)
    with lab.emulator.world.lock:
        left_alone(lab.emulator.cards.boards[0])
    with pytest.raises(DeviceTimeout):
        platform.card.read(timeline.total_samples)
    assert time.monotonic() - triggered_s < 0.8 * round_s
    platform.amplifier.disable()
    time.sleep(max(0.0, triggered_s + 1.2 * round_s - time.monotonic()))
    assert lab.violations() == ()  # the gate has been high again meanwhile
    lab.control("clear_faults")
    platform.outputs_off()
    assert sum(c.volts.shape[1] for c in collect(platform.card, short_shot(can), 5000))
    assert lab.violations() == ()
    platform.close()


@pytest.mark.parametrize("still_s", [0.0, 0.05, 0.3, 1.0])
def test_a_host_that_stands_still_while_power_is_on_never_connects_the_receiver_to_it(
    lab_of_its_own, monkeypatch, still_s
):
    lab = lab_of_its_own('io_cards.pa_gate={output="DIO7_P"}', 'io_cards.rx_connect={output="DIO6_P"}')
    pins = 'io_card.lines.pa_gate={pin="DIO7_P"}', 'io_card.lines.rx_connect={pin="DIO6_P"}'
    platform = lab.platform(*pins, "io_card.pin_delay_s=0.1", "io_card.sample_timeout_s=3.0")
    timeline = short_shot(platform.card.capabilities())
    at = PinLines.at
    stood = []

    def late(lines, arrived):
        """Stands still once, before the command that lowers the gate."""
        if not stood:
            stood.append(True)
            time.sleep(still_s)
        at(lines, arrived)

    monkeypatch.setattr(PinLines, "at", late)
    platform.card.program(timeline)
    platform.card.arm()
    platform.amplifier.enable()
    platform.amplifier.unmute()
    reason = "none"
    try:
        platform.card.trigger()
        left = timeline.total_samples
        while left:
            left -= platform.card.read(min(left, 1000)).volts.shape[1]
    except ShotRefused as refusal:
        reason = str(refusal)
    finally:
        platform.outputs_off()
    assert stood
    assert "late" in reason or "before its end was seen" in reason or (still_s < 0.3 and reason == "none")
    assert lab.violations() == ()
    platform.close()
