"""Faults of the card's wires and of the world behind it, as a driver would meet them."""

import time

import numpy as np
import pytest

from tests.kit.emulator_client import configure, connect, control, program, start, tone

LISTEN = [[0, 0, 1.8, 0]] + [[0, 0, 0, 1.8]] * 3
STEP = 2880


def record(emulator, count=4 * STEP):
    """(count, 2) codes of a shot with excitation along x."""
    emulator.world.amplifier(enabled=True, muted=False)
    client = connect(emulator)
    configure(client)
    program(client, STEP, LISTEN, [[1, 0, 1, 1]] + [[0, 0, 1, 1]] * 3)
    tone(client, 212.0, 0.25)
    start(client)
    codes, _ = client.pipelined(0, count)
    client.do("RP:TRIGGER OFF")
    client.close()
    return codes


def test_a_lost_reply_is_lost_and_the_next_one_comes(emulator, client):
    control(emulator, "wire_fault", kind="timeout", device="io_card_0", after=1)
    assert client.ask("RP:MODE?") == '"CONFIGURATION"'
    assert client.silent("RP:MODE?")
    assert client.ask("RP:MODE?") == '"CONFIGURATION"'


def test_half_a_reply_runs_into_the_next_one(emulator, client):
    control(emulator, "wire_fault", kind="half_reply", device="io_card_0")
    client.send("RP:MODE?")
    assert client.ask("RP:ADC:DEC?") == '"CONFIGU16'


def test_the_connection_ends_after_a_given_byte_of_the_samples_and_the_outputs_go_off(emulator, client):
    configure(client)
    tone(client, 500.0, 0.2)
    start(client)
    control(emulator, "wire_fault", kind="disconnect", device="io_card_0", stream="data", at_byte=3000)
    assert client.ask("RP:ADC:DATA:PIPELINED? 0,6100,610") == "1"
    client.receive(2461)
    with pytest.raises((ConnectionError, EOFError)):
        client.receive(3000)
    assert connect(emulator).ask("*IDN?")
    assert control(emulator, "outputs")["off"]


def test_a_slow_link_is_late_but_whole(emulator, client):
    control(emulator, "wire_fault", kind="slow_link", device="io_card_0", delay_s=0.2)
    began = time.monotonic()
    assert client.ask("RP:MODE?") == '"CONFIGURATION"'
    assert time.monotonic() - began >= 0.2


def test_a_one_way_link_obeys_and_says_nothing(emulator, client):
    control(emulator, "wire_fault", kind="one_way_link", device="io_card_0")
    assert client.silent("RP:ADC:DEC 64")
    control(emulator, "clear_faults")
    assert client.ask("RP:ADC:DEC?") == "64"


def test_a_converter_that_clips_shows_its_end_codes(emulator):
    control(emulator, "inject", kind="adc_clip")
    codes = record(emulator)
    assert np.count_nonzero(codes[:, 0] == 32767) == pytest.approx(61, abs=2)  # a millisecond


@pytest.mark.parametrize("keys", [{"shots": 3}, {"shot": "third"}, {"shot": 0}])
def test_a_fault_of_a_key_that_is_not_there_is_refused(emulator, keys):
    with pytest.raises(AssertionError, match="key 'shot"):
        control(emulator, "inject", kind="adc_clip", **keys)


def test_dropped_samples_shift_what_follows(emulator):
    whole = record(emulator)
    control(emulator, "hold_still")
    control(emulator, "inject", kind="dropped_samples")
    codes = record(emulator)
    late = slice(2 * STEP + 1220, 4 * STEP - 200)
    there = slice(late.start + 64, late.stop + 64)
    scale = np.abs(whole[late, 0]).max()
    assert np.abs(codes[late, 0] - whole[there, 0]).max() < 0.02 * scale
    assert np.abs(codes[late, 0] - whole[late, 0]).max() > 0.5 * scale


def test_a_worn_relay_bounces_into_the_record(emulator):
    """Its contacts close late for the last time, and every closing brings its transient or a gap."""
    clean = record(emulator)
    control(emulator, "hold_still")
    control(emulator, "inject", kind="relay_bounce")
    codes = record(emulator)
    settled = slice(STEP + 490, STEP + 750)  # 8 to 12 ms after the line rose
    assert np.abs(clean[settled, 0]).min() < np.abs(clean[settled, 0]).max()
    assert np.count_nonzero(codes[settled, 0] == 0) > np.count_nonzero(clean[settled, 0] == 0) + 20


def test_a_stuck_switch_never_connects_the_receiver(emulator):
    control(emulator, "inject", kind="switch_stuck")
    codes = record(emulator)
    assert np.all(codes[STEP + 100 :, 0] == 0)


def test_an_amplifier_that_trips_shows_its_fault_and_stays_off(emulator):
    control(emulator, "inject", kind="amplifier_trip")
    record(emulator)
    assert emulator.world.power.fault == "over-current"
    assert not control(emulator, "outputs")["amplifier_live"]
    control(emulator, "repair")


def test_a_link_that_is_deaf_does_nothing_that_it_is_told(emulator, client):
    assert client.ask("RP:ADC:DEC 32") == "1"
    control(emulator, "wire_fault", kind="deaf_link", device="io_card_0")
    assert client.silent("RP:ADC:DEC 64")
    control(emulator, "clear_faults")
    assert client.ask("RP:ADC:DEC?") == "32"


def test_a_fault_waits_for_the_question_and_the_moment_it_is_meant_for(emulator, client):
    control(emulator, "wire_fault", kind="timeout", device="io_card_0", command="DEC?", when="idle")
    control(emulator, "wire_fault", kind="timeout", device="io_card_0", command="MODE?", when="shot")
    assert client.ask("RP:MODE?") == '"CONFIGURATION"'
    assert client.silent("RP:ADC:DEC?")
    configure(client)
    start(client)
    assert client.silent("RP:MODE?")
    assert client.ask("RP:MODE?") == '"ACQUISITION"'


def test_power_that_could_reach_the_coils_is_on_record_to_the_sample(emulator):
    record(emulator)
    spans = control(emulator, "power_log")
    assert [s["shot"] for s in spans] == [1]
    assert spans[0]["stop_s"] - spans[0]["start_s"] == pytest.approx(STEP * 2048 / 125e6, abs=1e-9)


def test_welded_contacts_stay_on_the_receiver_until_they_are_repaired(emulator):
    control(emulator, "inject", kind="switch_welded")
    record(emulator)
    time.sleep(0.05)
    assert control(emulator, "outputs")["receiver"] == "receive"
    control(emulator, "repair")
    record(emulator)
    time.sleep(0.05)
    assert control(emulator, "outputs")["receiver"] == "transmit"
