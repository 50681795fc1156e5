"""The self-test over emulated wires: the same code, two real cards, serial switch and LNA, USB amplifier."""

from __future__ import annotations

from pathlib import Path

import pytest

from platform_daemon.core.schemas.requests import SelfTestOptions
from platform_daemon.features.self_test.work import SelfTest, SelfTestFailed
from platform_daemon.processes.assembly import start_engine
from tests.kit.emulated_lab import Lab

OPTIONS = SelfTestOptions(isolation_db=80.0)


def test_the_right_wiring_passes_and_nothing_of_a_real_platform_switches_it_off(lab: Lab) -> None:
    engine = start_engine(lab.file())
    try:
        report = SelfTest(engine.platform, engine.side, OPTIONS)()
    finally:
        engine.close()
    assert report is not None
    assert all(abs(gain - 1) < 0.3 for gain in report.gain.values())
    assert lab.violations() == ()


@pytest.mark.parametrize(
    ("wiring", "said"),
    [
        ("outputs=[0, 2, 1]", "coil y is connected to output 2"),
        ("factors=[-1.0, 1.0, 1.0]", "the polarity of x is inverted"),
        ("factors=[1.0, 1.0, 0.5]", "the gain of z is 0."),
    ],
)
def test_wrong_wiring_is_refused_in_words(tmp_path: Path, wiring: str, said: str) -> None:
    other = Lab(tmp_path, f"world.wiring.{wiring}")
    engine = start_engine(other.file())
    try:
        with pytest.raises(SelfTestFailed) as refused:
            SelfTest(engine.platform, engine.side, OPTIONS)()
    finally:
        engine.close()
        other.emulator.close()
    assert said in refused.value.why
