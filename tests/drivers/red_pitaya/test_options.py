"""A platform file that cannot be right is refused before anything is opened."""

from __future__ import annotations

import pytest

from drivers.errors import ConfigError, DeviceDenied, DeviceNotFound
from drivers.red_pitaya.backend import RedPitayaBackend
from drivers.red_pitaya.lock import lock_card
from drivers.red_pitaya.options import card_table
from tests.kit.scripted_daq_server import listener

BOARD = {"host": "127.0.0.1"}


@pytest.mark.parametrize(
    ("table", "complaint"),
    [
        ({}, "boards"),
        ({"boards": []}, "boards"),
        ({"boards": [BOARD, BOARD]}, "same address"),
        ({"boards": [{**BOARD, "inputs": [0, 0]}]}, "named twice"),
        ({"boards": [{**BOARD, "inputs": [2]}]}, "inputs"),
        ({"boards": [{**BOARD, "command_port": 0}]}, "command_port"),
        ({"boards": [BOARD], "decimation": 2047}, "decimation"),
        ({"boards": [BOARD], "decimation": 8}, "step_samples"),
        ({"boards": [BOARD], "step_samples": 5}, "at least 5.1"),
        ({"boards": [BOARD], "decimation": 8192, "chunk_samples": 6000}, "0.1 s"),
        ({"boards": [BOARD], "pin_delay_s": 0.6}, "pin_delay_s"),
        ({"boards": [BOARD], "colour": "red"}, "colour"),
        ({"boards": [BOARD], "lines": {"pa_gate": {"pin": "AO4"}}}, "no pin 'AO4'.*AO0, AO1"),
        ({"boards": [BOARD], "lines": {"pa_gate": {"pin": "DIO1_P"}}}, "no pin 'DIO1_P'"),
        ({"boards": [BOARD], "lines": {"pa_gate": {"pin": "AO1"}}, "prove_wiring": False}, "same pin"),
        ({"boards": [BOARD], "lines": {"rx_connect": {"board": 1, "pin": "AO0"}}}, "no board 1"),
        ({"boards": [BOARD], "lines": {"rx_connect": {"pin": "AO3"}}}, "rx_connect.*forgets AO3"),
        ({"boards": [BOARD], "lines": {"pa_gate": {"board": 1, "pin": "AO0"}}}, "on the master, board 0.*loose"),
        ({"boards": [{**BOARD, "inputs": []}]}, "no board has inputs"),
    ],
)
def test_what_is_wrong_is_named_and_nothing_is_opened(table, complaint, monkeypatch):
    monkeypatch.setattr("socket.create_connection", lambda *a, **k: pytest.fail("a connection was opened"))
    with pytest.raises(ConfigError, match=complaint):
        RedPitayaBackend({}).io_card(table)


def test_a_switch_on_the_cards_line_needs_the_card():
    timing = {"dead_time_s": 3e-3, "bounce_s": 1e-3, "settle_s": 4e-3, "no_readback": True}
    with pytest.raises(ConfigError, match=r"io_card\.backend"):
        RedPitayaBackend({}).tx_rx_switch(timing)
    with pytest.raises(ConfigError, match="must be less than 1"):
        RedPitayaBackend({}).tx_rx_switch({**timing, "dead_time_s": 3.0})


def test_one_card_needs_only_its_address():
    assert card_table({"boards": [{"host": "rp-f0a1b2"}]}).layout().outputs == 2


def test_a_card_that_another_daemon_holds_is_refused_before_it_is_connected():
    with listener() as free:
        port = free.getsockname()[1]
    board = {**BOARD, "command_port": port, "data_port": port}
    for same in ("127.0.0.1", "localhost"):
        with lock_card(same, port), pytest.raises(DeviceDenied, match="another daemon"):
            RedPitayaBackend({}).io_card({"boards": [board]})
    with pytest.raises(DeviceNotFound):  # the lock is free again, but no server listens
        RedPitayaBackend({}).io_card({"boards": [board]})


@pytest.mark.parametrize("value", [True, False])
def test_the_removed_option_for_shots_from_the_cards_memories_is_refused_by_name(value):
    with pytest.raises(ConfigError, match=r"'replay_watchdog' is unknown.*removed.*remove io_card\.replay_watchdog"):
        card_table({"boards": [{"host": "127.0.0.1"}], "replay_watchdog": value})
