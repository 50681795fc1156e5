"""A short look at a small crowd; `make attack` is the long one, whose numbers stand in docs/evidence/attack.md."""

from __future__ import annotations

from pathlib import Path

import pytest

from platform_daemon.core.schemas.requests import MOST_CHANGES, AcquisitionRequest
from tests.campaigns.attack.campaign import POLLED, Outcome, measured, table
from tests.campaigns.attack.daemon import attacked
from tests.campaigns.attack.load import DRY_RUN, Load
from tests.campaigns.attack.probe import Latencies
from tests.campaigns.attack.series import Shots

CROWD = Load(pollers=10, poll_hz=5, predictions=2, downloads=2, half_open=100, bodies_mb=(1, 5, 20))
FLOOD = Load(pollers=10, half_open=1000)


@pytest.mark.real_time
def test_stop_and_platform_are_answered_and_memory_stays_bounded_beside_a_crowd(tmp_path: Path) -> None:
    with attacked(tmp_path, rx_s=2.0) as daemon:
        outcome = measured(daemon, "a small crowd", CROWD, 2.0)
    assert outcome.stop.refused == outcome.platform.refused == 0
    # Other tests run beside this one: the bounds of the campaign, a few times over.
    assert outcome.stop.at(0.9) < 0.6
    assert max(outcome.peak_mb) < 1500
    assert outcome.told["poll 200"] > 20
    assert outcome.told["prediction 200"] >= 1
    assert outcome.told["body 413"] >= 2
    assert outcome.told["half-open connections"] >= 100
    assert "a small crowd" in table([outcome])


@pytest.mark.long
def test_stop_is_answered_on_its_own_port_while_the_main_port_is_flooded(tmp_path: Path) -> None:
    with attacked(tmp_path, rx_s=2.0) as daemon:
        outcome = measured(daemon, "a flood", FLOOD, 2.0)
    assert outcome.stop.refused == 0
    assert outcome.stop.at(0.9) < 0.6
    assert outcome.told["half-open connections"] >= 1000
    assert max(outcome.peak_mb) < 1500


def test_the_dry_run_of_the_crowd_is_the_largest_that_is_planned() -> None:
    assert len(AcquisitionRequest.model_validate(DRY_RUN).shot_changes or ()) == MOST_CHANGES


def test_a_bound_that_does_not_hold_is_told() -> None:
    fast, slow = Latencies((0.01,) * 100, 0), Latencies((0.01,) * 97 + (0.3,) * 3, 0)
    assert Outcome("x", fast, fast, (100, 500, 50)).broken() == []
    assert len(Outcome(POLLED[1], slow, slow, (100, 5000, 50)).broken()) == 3
    assert len(Outcome("x", slow, fast, (100, 500, 50)).broken()) == 0
    assert len(Outcome("x", fast, Latencies((0.01,), 1), (100, 500, 50)).broken()) == 1
    assert Shots("x", 3, 3, (), (0.4, 0.4), (100, 500, 50)).broken() == []
    assert len(Shots("x", 3, 2, ("late",), (0.4, 0.4, 1.0), (100, 500, 50)).broken()) == 2
    assert len(Outcome("x", fast, Latencies((), 0), (100, 500, 50)).broken()) == 1
