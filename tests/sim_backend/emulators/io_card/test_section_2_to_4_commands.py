"""The card's server as the reference describes it: syntax, replies, modes."""

import time

import pytest

from tests.kit.emulator_client import configure, connect, start


def test_2_lf_and_crlf_end_a_command_and_every_reply_ends_with_crlf(client):
    client.command.sendall(b"RP:MODE?\r\n")
    assert client.line() == '"CONFIGURATION"'  # `line` insists on CR LF
    assert client.ask("RP:MODE?") == '"CONFIGURATION"'


@pytest.mark.parametrize("header", ["RP:ADC:DEC?", "rp:adc:decimation?", "RP:adc:Decimation?", ":RP:ADC:DEC?"])
def test_2_headers_are_full_or_short_in_any_case(client, header):
    assert client.ask(header) == "16"


@pytest.mark.parametrize(
    "header", ["RP:ADC:DECI?", "RP:TRIG:ALV?", "RP:ADC:FIR?", "RP:ADC:WP:CURRENT?", "RP:DAC:CH0:SIG?"]
)
def test_2_nothing_between_short_and_full_and_nothing_that_only_the_documentation_knows(client, header):
    assert client.silent(header)
    assert client.ask("RP:MODE?") == '"CONFIGURATION"'


@pytest.mark.parametrize(("short", "full"), [("AL", "ALIVE"), ("PROP", "PROP"), ("MOD", "MODE")])
def test_2_the_short_form_is_the_leading_run_of_capitals(client, short, full):
    assert client.ask(f"RP:TRIG:{short}?") == client.ask(f"RP:TRIGGER:{full}?")


def test_2_numbers_are_glued_on_and_count_from_zero(client):
    client.do("RP:DAC:CHANNEL1:COMPONENT2:FREQUENCY 1000")
    assert float(client.ask("RP:DAC:CH1:COMP2:FREQ?")) == pytest.approx(1000)
    assert float(client.ask("RP:DAC:CH0:COMP2:FREQ?")) == 0.0


def test_2_surplus_arguments_are_ignored_with_success(client):
    assert client.ask("RP:ADC:DEC 16,32") == "1"
    assert client.ask("RP:ADC:DEC?") == "16"


def test_2_a_blank_instead_of_a_comma_gives_no_reply(client):
    assert client.silent("RP:ADC:DEC 16 32")
    assert client.ask("RP:ADC:DEC?") == "16"


def test_2_commands_joined_by_semicolons_are_relative_unless_they_start_with_a_colon(client):
    assert client.ask("RP:ADC:DEC 32;DEC?") == "1;32"
    assert client.ask("RP:ADC:DEC?;:RP:MODE?") == '32;"CONFIGURATION"'


def test_2_several_lines_in_one_send_are_answered_in_order(client):
    client.command.sendall(b"RP:ADC:DEC 64\nRP:ADC:DEC?\nRP:MODE?\n")
    assert [client.line() for _ in range(3)] == ["1", "64", '"CONFIGURATION"']


def test_2_a_command_split_over_two_segments_is_executed_half_finished(client):
    client.do("RP:ADC:DEC 128")
    client.command.sendall(b"RP:ADC:DEC 20")
    time.sleep(0.1)
    client.command.sendall(b"48\n")
    assert client.line() == "1"
    assert client.ask("RP:ADC:DEC?") == "20"


def test_2_a_header_split_over_two_segments_gives_no_answer(client):
    client.command.sendall(b"RP:ADC:")
    time.sleep(0.1)
    assert client.silent("DEC?")
    assert client.ask("RP:ADC:DEC?") == "16"


def test_2_a_command_longer_than_the_servers_reads_is_still_one_command(client):
    client.do("RP:DAC:CHANNEL0:COMPONENT0:FREQUENCY 212.00130000000000000000000000000000000000")
    assert float(client.ask("RP:DAC:CH0:COMP0:FREQ?")) == pytest.approx(212.0013, abs=1e-6)


def test_2_replies_come_in_several_writes(client):
    client.send("*IDN?")
    first = client.command.recv(100)
    while not first.endswith(b"\n"):
        first += client.command.recv(100)
    assert first == b"CUSTOM,REDPITAYA,0,0.1\r\n"


@pytest.mark.parametrize(
    ("command", "reply"),
    [
        ("RP:ADC:DEC 16", "1"),
        ("RP:ADC:DEC 15", "-2"),
        ("RP:ADC:DEC 6", "-2"),
        ("RP:ADC:DEC 8194", "-2"),
        ("RP:ADC:DEC", "-6"),
        ("RP:ADC:DEC fast", "-6"),
        ("RP:DAC:CH0:COMP0:AMP -0.1", "-2"),
        ("RP:DAC:CH0:COMP0:AMP 1.01", "-2"),
        ("RP:DAC:CH2:COMP0:AMP 0.1", "-3"),
        ("RP:DAC:CH0:COMP4:AMP 0.1", "-4"),
        ("RP:DAC:CH0:COMP3:AMP 0.1", "1"),
        ("RP:DAC:CH0:COMP3:SIG SINE", "-4"),
        ("RP:DAC:CH0:COMP0:SIG ROUND", "-6"),
        ("RP:DAC:CH0:COMP0:FREQ 0.01", "-2"),
        ("RP:DAC:CH0:OFFSET 1.5", "-2"),
        ("RP:TRIG ON", "-5"),
        ("RP:TRIG:ALIVE ON", "-5"),
        ("RP:ADC:DATA? 0,10", "-5"),
        ("RP:ADC:DATA:PIPE? 0,10,10", "-5"),
        ("RP:DAC:CH0:RAMPING:DOWN ON", "-5"),
        ("RP:DAC:SEQ:SAMPLESPERSTEP 200000000", "1"),
        ("RP:ADC:FIRE PERHAPS", "0"),
        ("RP:CALIB:ADC:CH0:SCALE?", "3.05176e-05"),
        ("RP:CALIB:ADC:CH2:SCALE?", "nan"),
        ("RP:CALIB:FLAGS", "15"),
        ("RP:VERSION:SERVER?", "11"),
        ("RP:VERSION:IMAGE?", "11"),
        ("RP:ADC:BUFFER:SIZE?", "33554432"),
        ("RP:DAC:CH0:COMP0:SIG?", '"SINE"'),
        ("RP:ADC:DATA:STOP?", "0"),
        ("RP:STATUS?", "0"),
        ("*OPC?", "1"),
        ("RP:ADC:DEC\t16", "1"),
        ("RP:ADC:DEC 16.9", "1"),
        ("RP:ADC:DEC 1e3", "-2"),  # a whole number ends where its digits end: 1
        ("RP:ADC:DEC nan", "-6"),
        ("RP:DAC:CH2:COMP4:AMP 0.1", "-3"),
        ("RP:COUNTERTRIGGER:ARM?", "0"),
        ("RP:COUNTERTRIGGER:ENABLE?", '"OFF"'),
        ("SYST:ERR:COUNT?", "0"),
    ],
)
def test_3_replies(client, command, reply):
    assert client.ask(command) == reply


def test_3_a_double_is_what_the_register_made_of_it(client):
    client.do("RP:DAC:CH0:COMP0:AMP 0.1")
    assert client.ask("RP:DAC:CH0:COMP0:AMP?") == "0.0999938962981048"


def test_3_unknown_headers_and_perf_get_no_reply(client):
    assert client.silent("RP:NONSENSE")
    assert client.silent("RP:PERF?")
    assert client.ask("RP:MODE?") == '"CONFIGURATION"'


def test_3_the_error_queue_takes_every_success_for_an_error(client):
    assert client.ask("SYST:ERR?") == '0,"No error"'
    client.do("RP:ADC:DEC 32")
    assert client.ask("SYST:ERR?") == '-200,"Execution error"'
    client.do("RP:ADC:DEC 32")
    assert client.ask("SYST:ERR:COUNT?") == "1"
    assert client.silent("*CLS")
    assert client.ask("SYST:ERR?") == '0,"No error"'


NEEDS_CONFIGURATION = {
    "RP:ADC:DEC 2048": "-5",
    "RP:TRIG:MODE INTERNAL": "-5",
    "RP:TRIG:PROP ON": "-5",
    "RP:DAC:CH0:RAMPING:ENABLE ON": "-5",
    "RP:DAC:SEQ:SAMPLESPERSTEP 100": "-7",
    "RP:DAC:SEQ:CHAN 2": "-7",
    "RP:DAC:SEQ:SET": "-7",
    "RP:COUNTER:SAMPLESPERSTEP 10": "-7",
    "RP:CALIB:ADC:CH0:SCALE 1": "-5",
    "RP:COUNTERTRIGGER:PRESAMPLES 3": "-5",
}
ANY_MODE = [
    "RP:DAC:CH0:COMP0:AMP 0",
    "RP:DAC:CH0:OFFSET 0",
    "RP:DAC:CH0:COMP0:FREQ 10",
    "RP:DAC:CH0:COMP0:PHASE 0",
    "RP:DAC:CH0:COMP0:SIG SQUARE",
    "RP:DAC:CH0:RAMPING 0.1",
    "RP:DIO:PIN7:SIDEP OFF",
    "RP:WATCHDOGMODE ON",
    "RP:INSTANTRESET:MODE ON",
    "RP:ADC:FIRENABLED ON",
    "RP:COUNTERTRIGGER:ENABLE OFF",
    "RP:CALIB:RESET",
]


def test_4_what_needs_configuration_is_refused_elsewhere(client):
    configure(client)
    client.do("RP:MODE ACQUISITION")
    assert {c: client.ask(c) for c in NEEDS_CONFIGURATION} == NEEDS_CONFIGURATION


@pytest.mark.parametrize("mode", ["CONFIGURATION", "ACQUISITION"])
def test_4_what_works_in_any_mode(client, mode):
    client.do(f"RP:MODE {mode}", *ANY_MODE)


def test_4_mode_survives_a_reconnect_and_transmission_cannot_be_asked_for(emulator):
    client = connect(emulator)
    client.do("RP:MODE ACQUISITION")
    assert client.ask("RP:MODE TRANSMISSION").startswith("-")
    client.close()
    assert connect(emulator).ask("RP:MODE?") == '"ACQUISITION"'


def test_4_commands_during_a_read_are_looked_at_between_chunks_and_trigger_off_is_refused(client):
    configure(client)
    start(client)
    chunk = 61035  # a second of the world
    assert client.ask(f"RP:ADC:DATA:PIPELINED? 0,{3 * chunk},{chunk}") == "1"
    client.send("RP:TRIGGER OFF")
    client.send("RP:MODE?")
    client.send("RP:MODE CONFIGURATION")
    assert client.line() == "-5"
    assert client.line() == '"TRANSMISSION"'
    assert client.line() == "-5"
    client.receive(3 * (4 * chunk + 21))
    assert client.ask("RP:MODE?") == '"ACQUISITION"'
    client.do("RP:TRIGGER OFF")


def test_4_a_second_read_during_one_is_refused(client):
    configure(client)
    start(client)
    assert client.ask("RP:ADC:DATA:PIPELINED? 0,60000,600") == "1"
    assert client.ask("RP:ADC:DATA:PIPELINED? 0,600,600") == "-5"
