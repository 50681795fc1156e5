"""SAMPLESPERSTEP after SEQ:SET: the card's memory is played without the server, as a ring; and what ends that.

Seen on the real server with a stand-in for the FPGA: the second play of 200, the ring, the sines from step 7372 on.
"""

from __future__ import annotations

import time

import numpy as np
import pytest

from drivers.timeline import DigitalLine
from sim_backend.emulators.emulator import LabEmulator
from sim_backend.emulators.io_card.sequence import Sequence
from tests.kit.emulator_client import LAB, RATE, configure, connect, control, program, start, tables, tone, until

STEP = 16
RING = 8192 * STEP
PULSE = [[0, 0, 1.8]] * 20 + [[0, 0, 0]] * 4
GATES = [[1, 0, 1]] * 20 + [[0, 0, 1]] * 4


@pytest.fixture
def emulator():
    """Real time."""
    made = LabEmulator(tables() | {"speed": 1.0}, LAB.parent)
    yield made
    made.close()


@pytest.fixture
def client(emulator):
    one = connect(emulator)
    configure(one)
    one.do("RP:INSTANTRESET:MODE ON")
    yield one
    one.close()


def loaded(client):
    """Twenty steps of gate and sine in the memory, and the server's hand off it."""
    program(client, STEP, PULSE, GATES)
    client.do(f"RP:DAC:SEQ:SAMPLESPERSTEP {STEP}")
    tone(client, 500.0, 0.2)
    start(client)


def to_be_played(emulator):
    """Spans in which gate and sine will be on if nothing else happens: three rounds of the ring."""
    timeline = emulator.cards.shot.timeline(0, 3 * RING)
    sines = [(b.start_sample, b.stop_sample) for b in timeline.bursts]
    return [(e.start_sample, e.stop_sample) for e in timeline.lines if e.line is DigitalLine.PA_GATE], joined(sines)


def joined(spans):
    """Those that follow each other without a gap as one."""
    out = []
    for a, b in sorted(spans):
        out = [*out[:-1], (out[-1][0], b)] if out and out[-1][1] == a else [*out, (a, b)]
    return out


def outputs(emulator):
    found = control(emulator, "outputs")
    return found["pa_gate"], found["playing"]


def at(emulator, elapsed_s):
    """Wait until so long after the trigger."""
    shot = emulator.cards.shot
    time.sleep(max(0.0, shot.start_s + elapsed_s - emulator.world.clock.monotonic_s()))


def test_each_trigger_plays_the_same_again_and_the_server_says_that_nothing_runs(emulator, client):
    loaded(client)
    for _ in range(3):
        assert int(client.ask("RP:STATUS?")) & 16 == 0
        until(lambda: len(emulator.cards.boards[0].history) > 0)
        assert emulator.cards.boards[0].registers.program.ring
        client.do("RP:TRIGGER OFF")
        assert outputs(emulator) == (False, [])
        assert float(client.ask("RP:DAC:CH0:COMP0:AMP?")) == pytest.approx(0.2, abs=1e-4)
        client.do("RP:TRIGGER ON")


def test_left_alone_it_is_a_ring_whose_last_steps_have_no_gate(emulator, client):
    loaded(client)
    gates, sines = to_be_played(emulator)
    assert gates == [(0, 320), (RING, RING + 320), (2 * RING, 2 * RING + 320)]
    free = 7372 * STEP
    assert sines == [(0, 320), (free, RING + 320), (RING + free, 2 * RING + 320), (2 * RING + free, 3 * RING)]


def test_a_new_client_empties_the_memory(emulator, client):
    loaded(client)
    second = connect(emulator)
    second.do("RP:TRIGGER OFF", "RP:TRIGGER ON")
    assert outputs(emulator) == (False, [])
    assert emulator.cards.boards[0].registers.program is None
    second.close()


# --- a server that dies


def test_a_card_whose_server_was_killed_plays_its_memory_round_and_round_until_a_server_is_there(emulator, client):
    program(client, STEP, [[0, 0, 1.8]] * 1200 + [[0, 0, 0]] * 4, [[1, 0, 1]] * 1200 + [[0, 0, 1]] * 4)
    long = 1200 * STEP  # 0.3 s: the test must be able to look
    tone(client, 500.0, 0.2)
    start(client)
    until(lambda: len(emulator.cards.boards[0].history) > 0)
    emulator.kill_server(0)
    gates, sines = to_be_played(emulator)
    assert gates == [(0, long), (RING, RING + long), (2 * RING, 2 * RING + long)]
    assert (0, long) in sines
    at(emulator, (long + 100) / RATE)
    assert outputs(emulator) == (False, [])
    at(emulator, (RING + 100) / RATE)
    assert outputs(emulator)[0]
    emulator.start_server(0)
    assert outputs(emulator) == (False, [])


def test_of_a_sequence_longer_than_the_memory_the_last_steps_that_were_filled_come_again():
    sequence, steps, dies_at = Sequence(), 20_000, 5000
    sequence.channels = 3
    sequence.upload(np.arange(3.0 * steps).reshape(steps, 3), 1)
    sequence.set(STEP)
    sequence.started()
    sequence.abandoned(dies_at * STEP + 7.0)
    left, last = sequence.program, dies_at + 7372
    played = [value for a, b, _, value, _ in left.runs(0, 0, (last + 2 * 8192) * STEP) for _ in range((b - a) // STEP)]
    first = np.arange(0.0, 3 * last, 3)
    np.testing.assert_array_equal(played, np.concatenate([first, first[-8192:], first[-8192:]]))
    assert left.stop == np.inf


def test_a_server_that_dies_while_nothing_is_prepared_leaves_nothing_to_be_played():
    sequence = Sequence()
    sequence.abandoned(0.0)
    assert sequence.program is None
    assert not sequence.busy
