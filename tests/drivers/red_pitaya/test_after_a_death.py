"""A daemon that died in a recording: the next one keeps clear of the moment at which the server ends it."""

from __future__ import annotations

import tempfile
import time

import pytest

from drivers.conformance.timelines import collect, short_shot
from drivers.errors import DeviceLost
from drivers.red_pitaya import pairing
from drivers.red_pitaya.board import Board
from drivers.red_pitaya.card import RedPitayaCard
from drivers.red_pitaya.lock import lock_card, note_path
from drivers.red_pitaya.options import card_table
from tests.kit.reference_daq_server import ReferenceServer


@pytest.fixture
def server(monkeypatch, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))  # ports are used again, and what is noted outlives a test
    made = ReferenceServer()
    yield made
    made.close()


def table_of(server):
    command_port, data_port = server.ports
    return card_table({"boards": [{"host": "127.0.0.1", "command_port": command_port, "data_port": data_port}]})


def noted(server):
    with lock_card("127.0.0.1", server.ports[0]) as lock:
        return lock.recording_until()


def test_what_is_noted_is_there_for_the_next_and_anything_else_is_no_recording(server):
    assert noted(server) == float("-inf")
    for until_s in (1234.5, 7.25):
        with lock_card("127.0.0.1", server.ports[0]) as lock:
            lock.note_recording(until_s)
        assert noted(server) == until_s
    note_path("127.0.0.1", server.ports[0]).write_text("process 7")
    assert noted(server) == float("-inf")


def test_a_shot_notes_when_its_recording_is_over(server):
    card = RedPitayaCard(table_of(server))
    timeline = short_shot(card.capabilities())
    begun_s = time.monotonic()
    collect(card, timeline, 5000)
    card.close()
    assert begun_s < noted(server) - timeline.total_samples / timeline.clock.rate_hz < begun_s + 1.0


@pytest.mark.parametrize(
    ("over_in_s", "waited_s"),
    [(-5.0, None), (-0.1, None), (0.0, None), (0.2, 0.1), (0.31, 0.21), (0.4, None), (1e6, None)],
)
def test_whoever_comes_next_waits_only_if_the_end_is_just_then(monkeypatch, over_in_s, waited_s):
    waits = []
    monkeypatch.setattr(pairing.time, "monotonic", lambda: 1000.0)
    monkeypatch.setattr(pairing.time, "sleep", waits.append)
    pairing.keep_clear(1000.0 + over_in_s)
    assert waits == ([] if waited_s is None else [pytest.approx(waited_s)])


def test_a_connection_that_the_end_of_the_one_before_takes_with_it_is_made_anew(server, monkeypatch):
    settle, lost = Board.settle, [DeviceLost("the card is gone", where="card")]

    def settle_but_for_the_first_time(board):
        if lost:
            raise lost.pop()
        settle(board)

    monkeypatch.setattr(Board, "settle", settle_but_for_the_first_time)
    card = RedPitayaCard(table_of(server))
    timeline = short_shot(card.capabilities())
    assert sum(c.volts.shape[1] for c in collect(card, timeline, 5000)) == timeline.total_samples
    card.close()
