"""The card's server as the reference describes it: waveforms and sequences, heard through the world's leakage.

While the contacts are on TRANSMIT the receiver hears the transmit voltage through its open contacts, so the record
shows what the outputs do, 24.25 samples late.
"""

import numpy as np
import pytest

from sim_backend.emulators.emulator import LabEmulator
from tests.kit.emulator_client import LAB, RATE, configure, connect, control, program, start, tables, tone, until

GATE = [0, 0, 1.8, 0]
OFF = [0, 0, 0, 0]
DELAY = 24


@pytest.fixture
def loop(lab_with):
    """A quiet lab with leakage of 1: the record is the output times the amplifier's gain; LNA gain 1."""
    emulator = lab_with(switch__isolation_db=20.0, lna__overload_v=100.0, lna__output_limit_v=100.0)
    emulator.world.lna_gain = 1.0
    emulator.world.amplifier(enabled=True, muted=False)
    client = connect(emulator)
    configure(client)
    client.emulator = emulator
    yield client
    client.close()


def played(client, count, codes=32768):
    """(count, 2) V at the outputs, as the record shows them, shifted to the instants they belong to."""
    raw, records = client.pipelined(0, count + DELAY + 1)
    client.records = records
    return raw[DELAY : DELAY + count] / codes


def shot(client, count):
    start(client)
    out = played(client, count)
    client.do("RP:TRIGGER OFF", "RP:MODE CONFIGURATION")
    return out


def expected(count, frequency, amplitude, phase=0.0):
    t = (np.arange(count) - 0.25) / RATE
    return np.where(t >= 0, amplitude * np.sin(2 * np.pi * frequency * t + phase), 0.0)


def test_6_a_gated_burst_is_exact_to_the_sample(loop):
    step = 287
    program(loop, step, [GATE] * 10 + [OFF] * 2, [[1, 0, 1, 1]] * 10 + [[0, 0, 1, 1]] * 2)
    f = float(loop.ask("RP:DAC:CH0:COMP0:FREQ 212.0013") == "1") * 212.0013
    tone(loop, f, 0.3)
    a = float(loop.ask("RP:DAC:CH0:COMP0:AMP?"))
    u = shot(loop, 14 * step)
    want = expected(14 * step, f, a) * (np.arange(14 * step) < 10 * step + 1)
    assert np.abs(u[1 : 10 * step, 0] - want[1 : 10 * step]).max() < 1.5 / 32768
    assert np.all(u[10 * step + 1 :, 0] == 0)
    assert np.all(u[:, 1] == 0)


MEASUREMENT = """RP:ADC:FIREnabled ON|RP:ADC:DECimation 2048|RP:TRIGger:MODe INTERNAL
RP:DAC:CH0:COMP0:SIGnaltype SINE|RP:DAC:CH0:COMP0:FREQuency 212.0013|RP:DAC:CH0:COMP0:PHAse 0|RP:DAC:CH0:OFFset 0
RP:DAC:SEQ:SAMPlesperstep 2879|RP:DAC:SEQ:CHan 2"""


@pytest.fixture
def gate_on_a_pin():
    """As `loop`, but the amplifier's gate is a DIO pin, so that a sequence of two channels is heard."""
    table = tables(switch__isolation_db=20.0, lna__overload_v=100.0, lna__output_limit_v=100.0)
    table["io_cards"]["pa_gate"] = {"board": 0, "output": "DIO7_P"}
    emulator = LabEmulator(table, LAB.parent)
    emulator.world.lna_gain = 1.0
    emulator.world.amplifier(enabled=True, muted=False)
    client = connect(emulator)
    configure(client)
    client.do("RP:DIO:PIN7:SIDEP ON")
    yield client
    client.close()
    emulator.close()


def test_6_3_the_complete_measurement_of_the_reference_word_by_word_twice(gate_on_a_pin):
    """Ten periods in one step of 2879 samples, then three steps of silence; the second shot without an upload."""
    loop = gate_on_a_pin
    for command in MEASUREMENT.replace("\n", "|").split("|"):
        assert loop.ask(command) == "1", command
    assert loop.upload("RP:DAC:SEQ:LUT 4,1", np.zeros((4, 2))) == "1"
    assert loop.upload("RP:DAC:SEQ:LUT:ENaBle", [[1, 1]] + [[0, 0]] * 3, "u1") == "1"
    for _ in range(2):
        for command in ("RP:DAC:SEQ:SET", "RP:DAC:CH0:COMP0:AMPlitude 0.3", "RP:MODe ACQUISITION", "RP:TRIGger ON"):
            assert loop.ask(command) == "1"
        codes, records = loop.pipelined(0, 4 * 2879 + 25, 610)
        assert all(status & 15 == 8 for status, *_ in records)
        until(lambda: int(loop.ask("RP:STATus?")) & 16 == 0)
        assert [loop.ask(c) for c in ("RP:TRIGger OFF", "RP:MODe CONFIGURATION")] == ["1", "1"]
        played_v = codes[DELAY:] / 32768
        assert np.abs(played_v[1:2878, 0] - expected(2879, 212.0013, 0.3)[1:2878]).max() < 1e-4
        assert np.all(played_v[2880:] == 0)


def test_6_sequence_values_are_added_and_do_not_scale_the_sine(loop):
    program(loop, 500, [[0.2, 0, 1.8, 0], [0.1, 0, 1.8, 0], OFF])
    tone(loop, 1000.0, 0.3)
    u = shot(loop, 1000)[5:, 0]
    sine = expected(1000, 1000.0, 0.3)[5:]
    steps = np.where(np.arange(5, 1000) < 500, 0.2, 0.1)
    away = np.abs(np.arange(5, 1000) - 500) > 1
    assert np.abs(u - sine - steps)[away].max() < 2e-4


def test_6_a_muted_step_silences_everything_while_the_phase_runs_on(loop):
    program(loop, 400, [GATE] * 3 + [OFF], [[1, 1, 1, 1], [0, 1, 1, 1], [1, 1, 1, 1], [0, 0, 0, 0]])
    tone(loop, 777.0, 0.3)
    loop.do("RP:DAC:CH0:OFFSET 0.1")
    u = shot(loop, 1200)[:, 0]
    want = expected(1200, 777.0, 0.3) + 0.1
    assert np.all(u[402:799] == 0)
    assert np.abs(u - want)[802:1199].max() < 2e-4


def test_6_a_resynchronised_step_is_silent_and_restarts_the_phase(loop):
    loop.do("RP:DAC:SEQ:SAMPLESPERSTEP 400", "RP:DAC:SEQ:CHAN 4")
    assert loop.upload("RP:DAC:SEQ:LUT 4,1", [GATE] * 3 + [OFF]) == "1"
    assert loop.upload("RP:DAC:SEQ:LUT:RESYNC", [[0, 0], [1, 0], [0, 0], [0, 0]], "u1") == "1"
    loop.do("RP:DAC:SEQ:SET")
    tone(loop, 777.0, 0.3)
    u = shot(loop, 1200)[:, 0]
    assert np.all(u[402:799] == 0)
    assert np.abs(u[802:1199] - expected(400, 777.0, 0.3)[2:399]).max() < 2e-4


def test_6_a_new_table_takes_the_enable_bits_away_and_leaves_the_resync_bits(loop):
    loop.do("RP:DAC:SEQ:SAMPLESPERSTEP 400", "RP:DAC:SEQ:CHAN 4")
    assert loop.upload("RP:DAC:SEQ:LUT 2,1", [GATE, OFF]) == "1"
    assert loop.upload("RP:DAC:SEQ:LUT:ENABLE", [[0] * 4] * 2, "u1") == "1"
    assert loop.upload("RP:DAC:SEQ:LUT:RESYNC", [[0, 0], [1, 0]], "u1") == "1"
    assert loop.upload("RP:DAC:SEQ:LUT 4,1", [GATE] * 3 + [OFF]) == "1"
    loop.do("RP:DAC:SEQ:SET")
    tone(loop, 777.0, 0.3)
    u = shot(loop, 1200)[:, 0]
    assert np.abs(u - expected(1200, 777.0, 0.3))[2:399].max() < 2e-4
    assert np.all(u[402:799] == 0)
    assert np.abs(u[802:1199] - expected(400, 777.0, 0.3)[2:399]).max() < 2e-4


def test_6_empty_tables_before_and_after_take_the_place_of_what_was_there(loop):
    loop.do("RP:DAC:SEQ:SAMPLESPERSTEP 200", "RP:DAC:SEQ:CHAN 3")
    assert loop.upload("RP:DAC:SEQ:LUT 2,1", [[0.2, 0, 1.8]] * 2) == "1"
    assert loop.upload("RP:DAC:SEQ:LUT:UP 1,1", [0.1, 0, 1.8]) == "1"
    assert loop.upload("RP:DAC:SEQ:LUT:DOWN 1,1", [0.3, 0, 1.8]) == "1"
    loop.do("RP:DAC:SEQ:LUT:UP 0,0", "RP:DAC:SEQ:LUT:DOWN 0,0", "RP:DAC:SEQ:SET")
    u = shot(loop, 800)[:, 0]
    assert np.abs(u[2:399] - 0.2).max() < 2e-4
    assert np.all(u[402:799] == 0)


def test_6_only_the_channels_of_the_sequence_are_gated(loop):
    program(loop, 1_000_000, [[0.0]], [[0]])
    tone(loop, 1000.0, 0.2)
    tone(loop, 1000.0, 0.1, channel=1)
    start(loop)
    assert int(loop.ask("RP:STATUS?")) == 8 | 16
    assert control(loop.emulator, "outputs")["playing"] == ["y"]


def test_6_the_tables_before_and_after_are_played_and_enabled(loop):
    loop.do("RP:DAC:SEQ:SAMPLESPERSTEP 200", "RP:DAC:SEQ:CHAN 3")
    assert loop.upload("RP:DAC:SEQ:LUT 1,2", [0.2, 0, 1.8]) == "1"
    assert loop.upload("RP:DAC:SEQ:LUT:ENABLE", [0, 1, 1], "u1") == "1"
    assert loop.upload("RP:DAC:SEQ:LUT:UP 1,1", [0.1, 0, 1.8]) == "1"
    assert loop.upload("RP:DAC:SEQ:LUT:DOWN 1,1", [0.3, 0, 1.8]) == "1"
    loop.do("RP:DAC:SEQ:SET")
    u = shot(loop, 800)[:, 0]
    middles = [u[100 + 200 * k] for k in range(4)]
    assert middles == pytest.approx([0.1, 0.0, 0.0, 0.3], abs=2e-4)


@pytest.mark.parametrize("signal", ["SQUARE", "TRIANGLE", "SAWTOOTH"])
def test_6_other_waveforms_have_their_rms(loop, signal):
    program(loop, 2000, [GATE, OFF])
    loop.do(f"RP:DAC:CH0:COMP0:SIG {signal}")
    tone(loop, 200.0, 0.5)
    u = shot(loop, 2000)[100:1931, 0]  # six periods
    rms = {"SQUARE": 0.5, "TRIANGLE": 0.5 / 3**0.5, "SAWTOOTH": 0.5 / 3**0.5}[signal]
    assert np.sqrt(np.mean(u**2)) == pytest.approx(rms, rel=0.02)


def test_6_an_arbitrary_table_is_played_at_the_fourth_components_frequency(loop):
    table = 0.4 * np.sin(2 * np.pi * 3 * np.arange(16384) / 16384)
    assert loop.upload("RP:DAC:CH0:AWG", table) == "1"
    loop.do("RP:DAC:CH0:COMP3:FREQ 100")
    program(loop, 2000, [GATE, OFF])
    u = shot(loop, 2000)[5:1999, 0]
    assert np.abs(u - expected(2000, 300.0, 0.4)[5:1999]).max() < 5e-4


def test_6_a_table_beyond_full_scale_is_refused(loop):
    assert loop.upload("RP:DAC:CH0:AWG", np.full(16384, 1.5)) == "0"
    assert loop.upload("RP:DAC:CH2:AWG", np.zeros(16384)) == "0"  # a channel that is none: taken all the same
    assert loop.ask("RP:MODE?") == '"CONFIGURATION"'


def test_6_an_output_is_scaled_in_the_register_so_that_volts_come_out_and_volts_are_read_back(loop):
    loop.do("RP:CALIB:DAC:CH0:SCALE 0.8")
    assert loop.ask("RP:DAC:CH0:COMP0:AMP 1.3") == "-2"
    program(loop, 2000, [GATE, OFF])
    tone(loop, 1000.0, 0.3)
    loop.do("RP:DAC:CH0:OFFSET 0.1")
    assert float(loop.ask("RP:DAC:CH0:COMP0:AMP?")) == pytest.approx(0.3, abs=1 / 65534 / 0.8)
    assert float(loop.ask("RP:DAC:CH0:OFFSET?")) == pytest.approx(0.1, abs=1 / 32767 / 0.8)
    u = shot(loop, 2000)[5:1999, 0]
    assert np.abs(u - 0.1 - expected(2000, 1000.0, 0.3)[5:1999]).max() < 2e-4


def test_6_a_ramp_reads_back_what_its_register_made_of_it(loop):
    assert loop.ask("RP:DAC:CH0:RAMP?") == "inf"  # never written
    loop.do("RP:DAC:CH0:RAMP 0.03")
    assert float(loop.ask("RP:DAC:CH0:RAMP?")) == pytest.approx(0.03, rel=1e-7)
    assert [loop.ask(f"RP:DAC:CH0:RAMP {s}") for s in (-1, 0, 40)] == ["-2"] * 3


def test_6_a_ramp_raises_the_amplitude_from_the_trigger_on(loop):
    loop.do("RP:DAC:CH0:RAMPING 0.03", "RP:DAC:CH0:RAMPING:ENABLE ON")
    assert loop.ask("RP:DAC:RAMPING:STATUS?") == "1"
    program(loop, 3000, [GATE, OFF])
    tone(loop, 2000.0, 0.5)
    u = np.abs(shot(loop, 3000)[:, 0])
    levels = [u[a : a + 100].max() for a in (50, 850, 2500)]
    assert levels[0] < 0.1
    assert 0.15 < levels[1] < 0.35
    assert levels[2] == pytest.approx(0.5, abs=0.01)


def test_6_1_a_sequence_clears_bit_4_and_all_amplitudes_at_its_end_but_not_the_offset(loop):
    program(loop, 300, [GATE, OFF], [[1, 1, 1, 1], [0, 0, 1, 1]])
    tone(loop, 500.0, 0.3)
    loop.do("RP:DAC:CH0:OFFSET 0.2")
    start(loop)
    until(lambda: int(loop.ask("RP:STATUS?")) & 16 == 0)
    assert loop.ask("RP:DAC:CH0:COMP0:AMP?") == "0"
    assert float(loop.ask("RP:DAC:CH0:OFFSET?")) == pytest.approx(0.2, abs=1e-4)
    assert control(loop.emulator, "outputs")["playing"] == ["x"]
    assert int(loop.ask("RP:STATUS?")) == 8


def test_6_1_the_same_sequence_plays_again_after_set_and_amplitude(loop):
    program(loop, 300, [GATE, OFF], [[1, 1, 1, 1], [0, 0, 1, 1]])
    tone(loop, 500.0, 0.3)
    first = shot(loop, 900)
    loop.do("RP:DAC:SEQ:SET", "RP:DAC:CH0:COMP0:AMP 0.3")
    assert np.abs(shot(loop, 900) - first).max() <= 1 / 32768
    loop.do("RP:DAC:SEQ:SET")
    assert np.all(shot(loop, 900) == 0)


def test_6_1_a_refused_upload_poisons_the_data_socket(loop):
    loop.do("RP:MODE ACQUISITION")
    assert loop.upload("RP:DAC:SEQ:LUT 2,1", [[0.4, 0, 1.8, 0], OFF]) == "-7"
    loop.do("RP:MODE CONFIGURATION", "RP:DAC:SEQ:SAMPLESPERSTEP 300", "RP:DAC:SEQ:CHAN 4")
    assert loop.upload("RP:DAC:SEQ:LUT 2,1", [[0.1, 0, 1.8, 0], OFF]) == "1"
    loop.do("RP:DAC:SEQ:SET")
    assert shot(loop, 300)[100, 0] == pytest.approx(0.4, abs=2e-4)


def test_6_1_an_upload_with_the_number_of_channels_unset_is_refused(loop):
    assert loop.upload("RP:DAC:SEQ:LUT 1,1", [0.0]) == "-7"


def test_6_1_set_twice_opens_the_gate_of_the_first_step(loop):
    program(loop, 300, [GATE, GATE, OFF], [[0, 0, 1, 1]] * 3)
    tone(loop, 500.0, 0.3)
    assert np.all(shot(loop, 300)[:, 0] == 0)
    loop.do("RP:DAC:SEQ:SET", "RP:DAC:SEQ:SET", "RP:DAC:CH0:COMP0:AMP 0.3")
    u = shot(loop, 600)[:, 0]
    assert np.abs(u[:300]).max() > 0.2
    assert np.all(u[302:] == 0)


def test_6_1_the_first_set_after_an_aborted_sequence_opens_the_first_step_and_a_reconnect_cures_it(loop):
    table, enable = [GATE] * 2 + [OFF], [[0, 0, 1, 1]] * 3
    program(loop, 300_000, table, enable)
    start(loop)
    loop.do("RP:TRIGGER OFF", "RP:MODE CONFIGURATION")
    program(loop, 300, table, enable)
    tone(loop, 500.0, 0.3)
    emulator = loop.emulator
    start(loop)
    outputs = control(emulator, "outputs")
    assert outputs["playing"] == ["x"] or int(loop.ask("RP:ADC:WP?")) > 300
    again = connect(emulator)
    configure(again)
    program(again, 300, table, enable)
    tone(again, 500.0, 0.3)
    assert np.all(shot(again, 300)[:, 0] == 0)


def test_6_1_a_sequence_without_a_table_ends_at_once_and_zeroes_the_amplitudes(loop):
    loop.do("RP:DAC:SEQ:SAMPLESPERSTEP 100", "RP:DAC:SEQ:CHAN 2", "RP:DAC:SEQ:SET")
    tone(loop, 500.0, 0.3)
    start(loop)
    assert loop.ask("RP:DAC:CH0:COMP0:AMP?") == "0"


def test_6_1_a_number_of_channels_after_a_set_begins_an_empty_sequence(loop):
    program(loop, 300, [GATE, OFF])
    start(loop)
    until(lambda: int(loop.ask("RP:STATUS?")) & 16 == 0)
    loop.do("RP:TRIGGER OFF", "RP:MODE CONFIGURATION", "RP:DAC:SEQ:CHAN 4", "RP:DAC:SEQ:SET")
    tone(loop, 500.0, 0.3)
    start(loop)
    assert loop.ask("RP:DAC:CH0:COMP0:AMP?") == "0"


def test_6_1_enable_bits_need_a_table_that_was_not_set_yet(loop):
    program(loop, 300, [GATE, OFF])
    assert loop.upload("RP:DAC:SEQ:LUT:ENABLE", [[1, 1, 1, 1]] * 2, "u1") == "-7"


def test_6_1_set_without_any_sequence_does_nothing_and_clear_of_none_is_harmless(loop):
    loop.do("RP:DAC:SEQ:SET", "RP:DAC:SEQ:CLEAR", "RP:DAC:SEQ:SET")
    start(loop)
    assert int(loop.ask("RP:STATUS?")) == 8


def test_6_1_clear_and_set_without_a_new_table_kill_the_server(loop):
    program(loop, 300, [GATE, OFF])
    loop.do("RP:DAC:SEQ:CLEAR")
    loop.send("RP:DAC:SEQ:SET")
    with pytest.raises((EOFError, ConnectionError)):
        loop.line()
    with pytest.raises(ConnectionError):
        connect(loop.emulator)


def test_6_without_steps_the_sequence_never_leaves_its_first_step(loop):
    program(loop, 0, [GATE, OFF])
    start(loop)
    _, records = loop.pipelined(0, 3000)
    assert all(r[0] & 16 for r in records)
