"""The contracts on real devices (or on an emulator that runs somewhere):

PLATFORM_DAEMON_HARDWARE=lab.toml pytest -n 0 -m hardware tests/drivers/conformance

PLATFORM_DAEMON_ENDPOINTS may name a file of endpoints.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from drivers.conformance import WHOLE_PLATFORM
from drivers.registry import build_platform
from platform_daemon.settings import load_platform

pytestmark = pytest.mark.hardware


@pytest.fixture(scope="module")
def platform():
    name = os.environ.get("PLATFORM_DAEMON_HARDWARE")
    if name is None:
        pytest.skip("PLATFORM_DAEMON_HARDWARE names no platform file")
    endpoints = os.environ.get("PLATFORM_DAEMON_ENDPOINTS")
    built = build_platform(load_platform(name, endpoints=Path(endpoints) if endpoints else None).section)
    yield built
    built.close()


TestCard, TestSwitch, TestAmplifier, TestLna, TestPlatform = WHOLE_PLATFORM
