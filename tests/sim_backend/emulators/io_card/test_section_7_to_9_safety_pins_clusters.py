"""The card's server as the reference describes it: safety-relevant behaviour, digital pins, clusters."""

import numpy as np
import pytest

from sim_backend.emulators.emulator import LabEmulator
from tests.kit.emulator_client import LAB, configure, connect, control, program, start, tables, tone, until


def outputs(emulator):
    return control(emulator, "outputs")


@pytest.fixture
def playing(emulator):
    """A client whose first output plays an ungated sine; the amplifier is live."""
    emulator.world.amplifier(enabled=True, muted=False)
    client = connect(emulator)
    configure(client)
    tone(client, 500.0, 0.2)
    start(client)
    assert outputs(emulator)["playing"] == ["x"]
    return client


def test_7_a_disconnect_while_idle_zeroes_the_outputs(emulator, playing):
    playing.close()
    until(lambda: outputs(emulator)["playing"] == [])


def test_7_a_client_that_dies_during_a_read_leaves_the_outputs_on_until_the_read_has_elapsed(emulator, playing):
    count = 10 * 61035  # ten seconds of the world
    assert playing.ask(f"RP:ADC:DATA:PIPELINED? 0,{count},610") == "1"
    playing.receive(2461)
    playing.close()
    began = control(emulator, "clock")["world_s"]
    assert outputs(emulator)["playing"] == ["x"]
    until(lambda: outputs(emulator)["playing"] == [], within_s=20)
    assert control(emulator, "clock")["world_s"] - began > 5


def test_7_a_new_connection_ends_what_a_dead_client_left_on(emulator, playing):
    assert playing.ask("RP:ADC:DATA:PIPELINED? 0,100000000,610") == "1"
    playing.close()
    connect(emulator).ask("*IDN?")
    assert outputs(emulator)["playing"] == []


def test_7_offsets_pins_trigger_and_mode_stay_when_the_client_goes(emulator, playing):
    playing.do("RP:DAC:CH0:OFFSET 0.2", "RP:DIO:PIN7:SIDEP ON")
    playing.close()
    client = connect(emulator)
    assert float(client.ask("RP:DAC:CH0:OFFSET?")) == pytest.approx(0.2, abs=1e-4)
    queries = {"DIO:PIN7:SIDEP": '"ON"', "TRIGGER": '"ON"', "MODE": '"ACQUISITION"', "DAC:CH0:COMP0:AMP": "0"}
    assert {q: client.ask(f"RP:{q}?") for q in queries} == queries


def test_7_the_watchdog_only_sets_a_bit(emulator, playing):
    playing.do("RP:WATCHDOGMODE ON")
    assert playing.ask("RP:WATCHDOGMODE?") == '"ON"'
    assert outputs(emulator)["playing"] == ["x"]


def test_7_the_instant_reset_works_only_in_its_mode_and_latches_until_trigger_off(emulator, playing):
    control(emulator, "instant_reset", level=True)
    assert outputs(emulator)["playing"] == ["x"]
    control(emulator, "instant_reset", level=False)
    playing.do("RP:INSTANTRESET:MODE ON")
    control(emulator, "instant_reset", level=True)
    assert outputs(emulator)["playing"] == []
    assert playing.ask("RP:INSTANTRESET:STATUS?") == "1"
    control(emulator, "instant_reset", level=False)
    assert outputs(emulator)["playing"] == []
    assert playing.ask("RP:INSTANTRESET:TRIGGERED?") == "1"
    assert playing.ask("RP:TRIGGER?") == '"ON"'
    playing.do("RP:TRIGGER OFF")
    assert playing.ask("RP:INSTANTRESET:TRIGGERED?") == "0"


def test_7_amplitude_zero_works_in_every_mode(emulator, playing):
    assert playing.ask("RP:ADC:DATA:PIPELINED? 0,100000000,610") == "1"
    playing.do("RP:DAC:CH0:COMP0:AMP 0")
    assert outputs(emulator)["playing"] == []


def test_7_calibration_setters_zero_amplitudes_and_offsets(client):
    tone(client, 500.0, 0.2)
    client.do("RP:DAC:CH1:OFFSET 0.2", "RP:CALIB:ADC:CH1:OFFSET 0.01")
    assert client.ask("RP:DAC:CH0:COMP0:AMP?") == "0"
    assert client.ask("RP:DAC:CH1:OFFSET?") == "0"
    assert client.ask("RP:CALIB:ADC:CH1:OFFSET?") == "0.01"
    client.do("RP:CALIB:RESET")
    assert client.ask("RP:CALIB:FLAGS") == "0"


def test_7_nothing_plays_while_the_trigger_is_off(emulator, client):
    tone(client, 500.0, 0.2)
    client.do("RP:DAC:CH0:OFFSET 0.3")
    assert outputs(emulator)["playing"] == []


@pytest.mark.parametrize("pin", ["PIN7:SIDEP", "PIN7:SIDEN", "PIN6:SIDEP", "PIN2:SIDEN"])
def test_8_a_pin_is_an_output_that_is_low_and_reads_its_pad(client, pin):
    assert client.ask(f"RP:DIO:{pin}:DIR?") == '"OUT"'
    assert client.ask(f"RP:DIO:{pin}?") == '"OFF"'
    client.do(f"RP:DIO:{pin} ON")
    assert client.ask(f"RP:DIO:{pin}?") == '"ON"'
    client.do(f"RP:DIO:{pin}:DIR IN")
    assert client.ask(f"RP:DIO:{pin}?") == '"OFF"'
    client.do(f"RP:DIO:{pin}:DIR OUT", f"RP:DIO:{pin}:HBRIDGE ON")
    assert client.ask(f"RP:DIO:{pin}:HBRIDGE?") == '"ON"'
    assert client.ask(f"RP:DIO:{pin}?") == '"OFF"'  # pulses of a waveform instead of its level
    client.do(f"RP:DIO:{pin}:HBRIDGE OFF")
    assert client.ask(f"RP:DIO:{pin}?") == '"ON"'


@pytest.mark.parametrize(
    ("command", "reply"),
    [("RP:DIO:PIN5:SIDEP ON", "-3"), ("RP:DIO:PIN0:SIDEN?", "-3"), ("RP:DIO:PIN7:SIDEP 1", "-6")],
)
def test_8_pins_that_cannot_be_used_and_words_that_are_none(client, command, reply):
    assert client.ask(command) == reply


def test_8_the_documented_pin_commands_do_not_exist(client):
    assert client.silent("RP:DIO:DIR DIO7_P,IN")
    assert client.silent("RP:DIO DIO7_P,1")


@pytest.fixture
def by_pins():
    table = tables()
    table["io_cards"]["pa_gate"] = {"board": 0, "output": "DIO7_P"}
    table["io_cards"]["rx_connect"] = {"board": 0, "output": "DIO6_P"}
    emulator = LabEmulator(table, LAB.parent)
    yield emulator
    emulator.close()


def test_8_lines_on_pins_act_at_once_and_without_a_trigger(by_pins):
    client = connect(by_pins)
    client.do("RP:DIO:PIN6:SIDEP ON")
    until(lambda: outputs(by_pins)["receiver"] == "receive")
    client.do("RP:DIO:PIN6:SIDEP OFF", "RP:DIO:PIN7:SIDEP ON")
    until(lambda: outputs(by_pins)["receiver"] == "transmit")
    assert outputs(by_pins)["pa_gate"]
    client.close()
    assert connect(by_pins).ask("RP:DIO:PIN7:SIDEP?") == '"ON"'
    assert outputs(by_pins)["pa_gate"]  # a pin stays ON after its client died


def test_8_power_on_the_connected_receiver_is_seen_without_a_shot_too(by_pins):
    by_pins.world.amplifier(enabled=True, muted=False)
    client = connect(by_pins)
    client.do("RP:DIO:PIN6:SIDEP ON", "RP:DIO:PIN7:SIDEP ON")
    violations = control(by_pins, "violations")
    assert "live amplifier" in violations[0]["cause"]
    control(by_pins, "repair")


def cluster(emulator):
    boards = [connect(emulator, k) for k in range(2)]
    for board in boards:
        configure(board)
    boards[0].do("RP:TRIGGER:PROP ON")
    boards[1].do("RP:TRIGGER:PROP OFF")
    for board in boards:
        board.do("RP:MODE ACQUISITION")
    return boards


def test_9_the_masters_trigger_starts_both_cards_with_a_common_write_pointer(emulator):
    master, slave = cluster(emulator)
    master.do("RP:TRIGGER ON")
    assert [b.ask("RP:TRIGGER?") for b in (master, slave)] == ['"ON"', '"ON"']
    pointers = [int(b.ask("RP:ADC:WP?")) for b in (master, slave, master)]
    assert pointers == sorted(pointers)


def test_9_without_propagation_the_slave_stays_off(emulator):
    master, slave = cluster(emulator)
    master.do("RP:MODE CONFIGURATION", "RP:TRIGGER:PROP OFF", "RP:MODE ACQUISITION", "RP:TRIGGER ON")
    assert slave.ask("RP:TRIGGER?") == '"OFF"'
    assert slave.ask("RP:ADC:WP?") == "0"


def test_9_the_wire_of_the_external_trigger():
    table = tables()
    table["io_cards"]["trigger_wire"] = "dio"
    emulator = LabEmulator(table, LAB.parent)
    boards = [connect(emulator, k) for k in range(2)]
    for board in boards:
        board.do("RP:TRIGGER:MODE EXTERNAL", "RP:MODE ACQUISITION")
    boards[0].do("RP:TRIGGER ON")
    assert [b.ask("RP:TRIGGER?") for b in boards] == ['"ON"', '"ON"']
    emulator.close()


def test_9_keep_alive_freezes_the_slaves_pointer_until_it_is_switched_off(emulator):
    master, slave = cluster(emulator)
    master.do("RP:TRIGGER ON")
    until(lambda: int(slave.ask("RP:ADC:WP?")) > 5000)
    slave.do("RP:TRIGGER:ALIVE ON")
    master.do("RP:TRIGGER OFF")
    frozen = int(slave.ask("RP:ADC:WP?"))
    assert frozen > 5000
    assert int(slave.ask("RP:ADC:WP?")) == frozen
    codes, records = slave.pipelined(0, 1220)
    assert codes.shape == (1220, 2)
    assert not records[0][0] & 8
    slave.do("RP:TRIGGER:ALIVE OFF")
    assert slave.ask("RP:ADC:WP?") == "0"


def test_9_keep_alive_cannot_be_switched_off_while_the_trigger_is_on(emulator):
    master, slave = cluster(emulator)
    master.do("RP:TRIGGER ON")
    slave.do("RP:TRIGGER:ALIVE ON", "RP:TRIGGER:ALIVE OFF")
    assert slave.ask("RP:TRIGGER:ALIVE?") == '"ON"'
    slave.do("RP:TRIGGER OFF")  # its own, not the master's
    assert slave.ask("RP:TRIGGER:ALIVE?") == '"ON"'
    master.do("RP:TRIGGER OFF")
    slave.do("RP:TRIGGER:ALIVE OFF")
    assert slave.ask("RP:TRIGGER:ALIVE?") == '"OFF"'


def test_9_two_cards_make_one_record_of_three_axes(lab_with):
    emulator = lab_with(noise__scale=1.0)
    emulator.world.amplifier(enabled=True, muted=False)
    master, slave = cluster(emulator)
    master.do("RP:MODE CONFIGURATION")
    step = 2880
    table = [[0, 0, 1.8, 0], [0, 0, 0, 1.8], [0, 0, 0, 1.8], [0, 0, 0, 0]]
    program(master, step, table, [[1, 1, 1, 1]] + [[0, 0, 1, 1]] * 3)
    tone(master, 10 * 125e6 / 2048 / step, 0.25)
    start(master)
    x_and_y, _ = master.pipelined(0, 3 * step)
    z, records = slave.pipelined(0, 3 * step)
    heard = slice(step + 700, 3 * step)
    assert x_and_y[heard, 0].std() > 1000
    assert x_and_y[heard, 1].std() < x_and_y[heard, 0].std()
    assert np.all(z[:, 1] == 0)  # nothing is connected there
    assert z[heard, 0].std() > 1
    assert all(r[0] == 8 for r in records)
    assert control(emulator, "violations") == []


def test_a_shot_over_the_wires_is_that_of_the_simulated_platform(lab_with):
    """The same burst and lines, played by registers here and by a timeline there, differ by the ADC's steps only."""
    from drivers.timeline import DigitalLine, LineLevel
    from tests.kit.simulated_bench import QUIET, Bench, timeline

    step, steps = 2880, 4
    bench = Bench("thread", **(QUIET | {"card__adc_bits": 16, "receive__chain": "ideal"}))
    lines = (LineLevel(DigitalLine.PA_GATE, 0, step), LineLevel(DigitalLine.RX_CONNECT, step, steps * step))
    plan = timeline(bench.channels[0], 215e-6, tx=step, switch=700, rx=steps * step - step - 700, lines=lines)
    burst = plan.bursts[0]
    emulator = lab_with()
    emulator.world.amplifier(enabled=True, muted=False)
    client = connect(emulator)
    configure(client)
    table = [[0, 0, 1.8, 0]] + [[0, 0, 0, 1.8]] * (steps - 1)
    program(client, step, table, [[1, 0, 1, 1]] + [[0, 0, 1, 1]] * (steps - 1))
    tone(client, burst.frequency_hz, burst.amplitude_v)
    client.do(f"RP:DAC:CH0:COMP0:PHASE {burst.phase_rad}")
    bench.backend.world.lna_gain = emulator.world.lna_gain
    start(client)
    codes, _ = client.pipelined(0, steps * step + 25)
    bench.start(plan)
    volts = bench.card.read(10**6).volts
    span = slice(step + 700, steps * step - 1)
    there = volts[0, span] * 32768
    here = (0.75 * codes[24:-1, 0] + 0.25 * codes[25:, 0])[span]
    assert np.abs(there).max() > 1000
    assert np.abs(here - there).max() < 3e-3 * np.abs(there).max()
