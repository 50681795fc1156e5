"""The contracts on real devices (or on an emulator that runs somewhere):

PLATFORM_DAEMON_HARDWARE=lab.toml pytest -n 0 -m hardware tests/drivers/conformance

PLATFORM_DAEMON_ENDPOINTS may name a file of endpoints.
"""

from __future__ import annotations

import os
import socket
from pathlib import Path

import pytest

from drivers.conformance import WHOLE_PLATFORM
from drivers.red_pitaya.options import card_table
from drivers.registry import build_platform
from platform_daemon.core.settings import load_platform

pytestmark = pytest.mark.hardware


@pytest.fixture(scope="module")
def section():
    name = os.environ.get("PLATFORM_DAEMON_HARDWARE")
    if name is None:
        pytest.skip("PLATFORM_DAEMON_HARDWARE names no platform file")
    endpoints = os.environ.get("PLATFORM_DAEMON_ENDPOINTS")
    return load_platform(name, endpoints=Path(endpoints) if endpoints else None).section


@pytest.fixture(scope="module")
def platform(section):
    built = build_platform(section)
    yield built
    built.close()


TheCard, TestSwitch, TestAmplifier, TestLna, TestPlatform = WHOLE_PLATFORM


class TestCard(TheCard):
    """Where it is a card with ports, strangers knock at each of the first one's."""

    @pytest.fixture(params=["command_port", "data_port"])
    def stranger(self, section, request):
        if section.io_card.backend != "red_pitaya":
            return None
        board = card_table(section.io_card.options()).boards[0]
        return lambda: socket.create_connection((board.host, getattr(board, request.param)), timeout=5).close()
