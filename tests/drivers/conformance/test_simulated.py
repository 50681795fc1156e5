"""The simulated platform in this process keeps the contracts, with and without a grid of edges."""

from __future__ import annotations

import pytest

from drivers.conformance import WHOLE_PLATFORM, AmplifierContract
from drivers.registry import build_platform
from platform_daemon.core.settings import load_platform

OVERRIDES = {
    "edges anywhere": [],
    "edges on a grid": ["io_card.step_samples=16"],
    "real time": ['backends.simulated.clock.mode="realtime"'],
}


@pytest.fixture(scope="class", params=list(OVERRIDES))
def platform(request):
    built = build_platform(load_platform("simulated", OVERRIDES[request.param]).section)
    yield built
    built.close()


TestCard, TestSwitch, _, TestLna, TestPlatform = WHOLE_PLATFORM


class TestAmplifier(AmplifierContract):
    @pytest.fixture
    def trip(self, platform):
        world = platform.backends["simulated"].world
        return world.trip_amplifier
