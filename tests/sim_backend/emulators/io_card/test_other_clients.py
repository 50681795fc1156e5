"""Other people's clients of the card's server: how they speak, and that they get what they expect."""

import time

import numpy as np
import pytest

from tests.kit.emulator_client import connect, control

SIMPLE = [
    "RP:MODe CONFIGURATION",
    "RP:ADC:DECimation 16",
    "RP:TRIGger:MODe INTERNAL",
    "RP:DAC:CHannel0:COMPonent0:FREQ 10000",
    "RP:DAC:CHannel0:COMPonent0:SIGnaltype SINE",
    "RP:DAC:CHannel0:COMPonent0:AMP 0.5",
    "RP:DAC:CHannel0:OFF 0",
    "RP:DAC:CHannel0:COMPonent0:PHA 0.0",
    "RP:MODe ACQUISITION",
    "RP:TRIGger ON",
]


@pytest.mark.parametrize("samples", [780, 1024])
def test_the_shipped_python_client_reads_780_samples(emulator, samples):
    """It passes bytes as the chunk, trusts one read to bring all the samples and another the record."""
    client = connect(emulator)
    for command in SIMPLE:
        client.send(command)
        assert client.line() == "1"
    while int(client.ask("RP:ADC:WP?")) < samples:
        pass
    assert client.ask(f"RP:ADC:DATA:PIPELINED? 0,{samples},{min(4096, 4 * samples)}") == "1"
    time.sleep(0.05)
    u = np.frombuffer(client.data.recv(4 * samples), np.int16).reshape(2, samples, order="F")
    assert u.shape == (2, samples)
    assert len(client.data.recv(4096)) == 21
    client.data.settimeout(0.1)
    with pytest.raises(TimeoutError):
        client.data.recv(1)


def test_a_start_up_in_the_manner_of_the_julia_client(emulator):
    """Version, calibration of both converters, counter trigger, and a batch of commands in one write."""
    client = connect(emulator)
    assert client.ask("RP:VERsion:IMAGe?") == client.ask("RP:VERsion:SERVer?") == "11"
    for converter in ("ADC", "DAC"):
        for channel in (0, 1):
            for value in ("SCA", "OFF"):
                float(client.ask(f"RP:CALib:{converter}:CHannel{channel}:{value}?"))
    for command in ("RP:CounterTrigger:ENable OFF", "RP:TRIGger:ALiVe?", "RP:MODe?"):
        assert client.ask(command)
    for flag in ("RP:CounterTrigger:ARM?", "RP:STATus:LOSTSteps?", "RP:ADC:DATa:SToP?"):
        assert client.ask(flag) in ("0", "1")  # it reads them as Bool, which knows no words
    batch = ["RP:ADC:DECimation 64", "RP:ADC:DECimation?", "RP:DAC:CH0:COMP1:FREQuency 1000.0", "RP:TRIGger:PROP?"]
    client.command.sendall("".join(c + "\n" for c in batch).encode())
    assert [client.line() for _ in batch] == ["1", "64", "1", '"OFF"']


def test_a_cluster_read_takes_chunk_by_chunk_from_every_card(emulator):
    cards = [connect(emulator, k) for k in range(2)]
    for k, card in enumerate(cards):
        card.do("RP:ADC:DECimation 2048", f"RP:TRIGger:PROP {'ON' if k == 0 else 'OFF'}", "RP:MODe ACQUISITION")
    cards[0].do("RP:TRIGger ON")
    chunk, chunks = 6103, 4
    for card in cards:
        assert card.ask(f"RP:ADC:DATa:PIPElined? 0,{chunk * chunks},{chunk}") == "1"
    for _ in range(chunks):
        for card in cards:
            card.receive(4 * chunk)
            assert card.receive(21)[0] == 8
    cards[0].do("RP:TRIGger OFF")
    assert control(emulator, "outputs")["off"]
