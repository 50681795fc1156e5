"""The card's server as the reference describes it: trigger, write pointer, reading."""

import time

import numpy as np
import pytest

from sim_backend.emulators.emulator import LabEmulator
from tests.kit.emulator_client import LAB, RATE, configure, connect, control, start, tables, until


def test_5_1_decimation_rescales_steps_that_were_set_before(client):
    configure(client)
    client.do("RP:DAC:SEQ:SAMPLESPERSTEP 100", "RP:ADC:DECIMATION 1024")
    assert client.ask("RP:DAC:SEQ:SAMPLESPERSTEP?") == "200"


def test_5_2_the_write_pointer_moves_in_steps_of_32_pairs_at_the_cards_rate(emulator, client):
    configure(client)
    start(client)
    began = control(emulator, "clock")["world_s"]
    until(lambda: int(client.ask("RP:ADC:WP?")) > 20000)
    before = control(emulator, "clock")["world_s"]
    pointer = int(client.ask("RP:ADC:WP?"))
    after = control(emulator, "clock")["world_s"]
    assert pointer % 32 == 0
    assert (before - began) * RATE - 32 <= pointer  # the trigger came before `began` was read
    assert pointer <= (after - began) * RATE + 32 + 0.2 * RATE * 10


def test_5_2_trigger_off_clears_the_pointer_and_the_ram_can_still_be_read(client):
    configure(client)
    start(client)
    codes, _ = client.pipelined(0, 3000)
    client.do("RP:TRIGGER OFF")
    assert client.ask("RP:ADC:WP?") == "0"
    assert client.ask("RP:ADC:DATA? 0,3000") == "1"
    again = np.frombuffer(client.receive(12000), "<i2").reshape(-1, 2)
    assert np.array_equal(again, codes)
    assert client.ask("RP:STATUS?") == "0"


def test_5_2_keep_alive_freezes_the_pointer(client):
    configure(client)
    start(client)
    client.do("RP:TRIGGER:ALIVE ON")
    assert client.ask("RP:TRIGGER:ALIVE?") == '"ON"'


def test_5_3_samples_are_int16_pairs_scaled_by_the_calibration(lab_with):
    table = tables()
    table["io_cards"]["boards"][0] |= {"adc_scale_v": [2e-5, 4e-5], "adc_offset_v": [0.1, -0.1]}
    emulator = LabEmulator(table, LAB.parent)
    try:
        client = connect(emulator)
        assert client.ask("RP:CALIB:ADC:CH0:SCALE?") == "2e-05"
        assert client.ask("RP:CALIB:ADC:CH1:OFFSET?") == "-0.1"
        configure(client)
        start(client)
        codes, _ = client.pipelined(0, 610)
        assert np.all(codes == [-5000, 2500])  # a quiet input is 0 V
    finally:
        emulator.close()


def test_5_3_a_decimation_that_is_no_power_of_two_leaves_the_gain_of_its_filter_in_the_samples(lab_with):
    table = tables()
    table["io_cards"]["boards"][0]["adc_offset_v"] = [0.1, -0.1]
    emulator = LabEmulator(table, LAB.parent)
    try:
        client = connect(emulator)
        configure(client, 1000)
        start(client)
        codes, _ = client.pipelined(0, 610)
        gain = 500**6 / 2**54  # R = 500
        assert np.all(np.abs(codes - np.array([-3276.8, 3276.8]) * gain) <= 0.5)
    finally:
        emulator.close()


def test_5_4_chunks_and_records_add_up(client):
    configure(client)
    start(client)
    codes, records = client.pipelined(0, 5000, 2000)
    assert codes.shape == (5000, 2)
    assert len(records) == 3
    for status, lag, sent, *_ in records:
        assert status == 8  # trigger on, no sequence, no flag
        assert lag < 2**25
        assert sent < 2**25


def test_5_4_a_read_may_begin_in_the_future_and_in_the_past(client):
    configure(client)
    start(client)
    client.pipelined(30000, 610)
    first, _ = client.pipelined(0, 610)
    assert first.shape == (610, 2)
    assert int(client.ask("RP:ADC:WP?")) >= 30592


def test_5_4_reads_that_overlap_bring_the_same_samples(lab_with):
    client = connect(lab_with(quiet=False))
    configure(client)
    start(client)
    whole, _ = client.pipelined(0, 4000, 777)
    part, _ = client.pipelined(1000, 2000, 610)
    assert whole.std() > 1
    assert np.array_equal(whole[1000:3000], part)


def test_5_4_without_samples_the_server_hangs_and_only_a_new_connection_frees_it(emulator):
    client = connect(emulator)
    configure(client)
    client.do("RP:MODE ACQUISITION")
    assert client.ask("RP:ADC:DATA:PIPELINED? 0,100,100") == "1"
    assert client.silent("RP:ADC:WP?")
    assert client.silent("RP:ADC:DATA:STOP?")
    again = connect(emulator)
    again.send("\n*IDN?")
    lines = [again.line()]
    while not lines[-1].startswith("CUSTOM"):
        lines.append(again.line())
    assert lines[:-1] == ["0", "1"]
    assert again.ask("RP:MODE?") == '"ACQUISITION"'


def test_5_4_stop_ends_the_stream_after_a_whole_chunk_and_record(client):
    configure(client)
    start(client)
    chunk = 20000
    assert client.ask(f"RP:ADC:DATA:PIPELINED? 0,{100 * chunk},{chunk}") == "1"
    head = client.receive(4 * chunk + 21)
    client.send("RP:ADC:DATA:STOP?")
    assert client.line() == "1"
    client.data.settimeout(0.3)
    rest = b""
    try:
        while True:
            rest += client.data.recv(1 << 16)
    except TimeoutError:
        pass
    assert len(head + rest) % (4 * chunk + 21) == 0
    assert client.ask("RP:MODE?") == '"ACQUISITION"'
    assert client.ask("RP:ADC:DATA:STOP?") == "0"


def test_5_4_stop_while_the_data_socket_is_blocked_cuts_a_chunk_and_sends_no_record():
    table = tables() | {"speed": 100.0}
    del table["specimen"]
    emulator = LabEmulator(table, LAB.parent)
    client = connect(emulator)
    configure(client)
    start(client)
    count = 2_000_000
    until(lambda: int(client.ask("RP:ADC:WP?")) > count)
    assert client.ask(f"RP:ADC:DATA:PIPELINED? 0,{count},{count}") == "1"
    time.sleep(0.5)  # no client reads: the sockets fill up
    assert client.ask("RP:ADC:DATA:STOP?") == "1"
    client.data.settimeout(0.3)
    received = 0
    try:
        while True:
            received += len(client.data.recv(1 << 20))
    except TimeoutError:
        pass
    emulator.close()
    assert 0 < received < 4 * count


def test_5_5_a_simple_read_does_not_wait_and_brings_no_record(client):
    configure(client)
    start(client)
    assert client.ask("RP:ADC:DATA? 1000000,500") == "1"
    assert client.receive(2000) == bytes(2000)  # never written
    assert client.ask("RP:STATUS?") == "8"


def test_5_6_status_is_text_and_has_three_parts(client):
    parts = [client.ask(f"RP:STATUS:{p}?") for p in ("OVERWRITTEN", "CORRUPTED", "LOSTSTEPS")]
    assert parts == ["0", "0", "0"]


def test_5_6_perf_sends_the_figures_of_the_last_record_while_samples_are_sent_and_nothing_otherwise(client):
    configure(client)
    start(client)
    chunk = 20000
    assert client.ask(f"RP:ADC:DATA:PIPELINED? 0,{3 * chunk},{chunk}") == "1"
    client.send("RP:PERF?")
    raw = client.receive(3 * (4 * chunk + 21) + 20)
    at = [k * (4 * chunk + 21) for k in (1, 2, 3)]
    records = [raw[a - 20 : a] for a in at[:1]]
    assert raw[at[0] : at[0] + 20] in records  # it came between the first chunk and the second
    assert client.silent("RP:PERF?")
    client.data.settimeout(0.1)
    with pytest.raises(TimeoutError):
        client.data.recv(1)


def test_5_6_the_log_comes_on_the_data_socket_without_a_reply(client):
    assert client.silent("RP:LOG?")
    length = int.from_bytes(client.receive(8), "little")
    assert len(client.receive(length)) == length


@pytest.mark.parametrize(("kind", "bit"), [("overwritten", 1), ("corrupted", 2)])
def test_5_7_flags_speak_for_one_chunk(emulator, client, kind, bit):
    control(emulator, "inject", kind=kind)
    configure(client)
    start(client)
    _, records = client.pipelined(0, 6100)
    flagged = [k for k, r in enumerate(records) if r[0] & bit]
    assert flagged == [5]
    assert client.ask("RP:STATUS?") == "8"


def test_5_7_lost_steps_stay_until_the_next_set(emulator, client):
    control(emulator, "inject", kind="lost_steps")
    configure(client)
    client.do("RP:DAC:SEQ:SAMPLESPERSTEP 100", "RP:DAC:SEQ:CHAN 1")
    assert client.upload("RP:DAC:SEQ:LUT 2,1", [0, 0]) == "1"
    client.do("RP:DAC:SEQ:SET")
    start(client)
    _, records = client.pipelined(0, 6100)
    assert [r[0] >> 2 & 1 for r in records] == [0] * 5 + [1] * 5
    assert client.ask("RP:STATUS:LOSTSTEPS?") == "1"
    client.do("RP:TRIGGER OFF", "RP:MODE CONFIGURATION", "RP:DAC:SEQ:SET")
    assert client.ask("RP:STATUS:LOSTSTEPS?") == "0"


def test_5_7_a_card_that_stops_writing_makes_the_stream_stop(emulator, client):
    control(emulator, "inject", kind="card_timeout")
    configure(client)
    start(client)
    assert client.ask("RP:ADC:DATA:PIPELINED? 0,6100,610") == "1"
    client.receive(4 * (2440 + 21))
    client.data.settimeout(0.3)
    with pytest.raises(TimeoutError):
        client.receive(4 * 3660)


def test_5_8_an_enabled_counter_trigger_that_is_not_armed_holds_the_trigger_back(client):
    configure(client)
    client.do("RP:COUNTERTRIGGER:ENABLE ON")
    start(client)
    assert client.ask("RP:TRIGGER?") == '"OFF"'
    client.do("RP:COUNTERTRIGGER:ENABLE OFF")
    assert client.ask("RP:TRIGGER?") == '"ON"'


def test_5_8_trigger_off_also_ends_keep_alive(client):
    configure(client)
    start(client)
    client.do("RP:TRIGGER:ALIVE ON", "RP:TRIGGER OFF")
    assert client.ask("RP:TRIGGER:ALIVE?") == '"OFF"'


def test_free_running_longer_than_any_leg_stays_continuous(lab_with):
    emulator = lab_with(quiet=False, noise__scale=0.0)
    client = connect(emulator)
    configure(client)
    start(client)
    early, _ = client.pipelined(0, 610)  # the first leg is short
    late, records = client.pipelined(90000, 610)
    assert np.all(early == 0)
    assert records[0][0] == 8
    assert late.shape == (610, 2)
