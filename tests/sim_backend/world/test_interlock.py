"""The world sees when the receiver is connected to the live amplifier, and breaks the LNA as reality would."""

import numpy as np
import pytest

from drivers.errors import DeviceFault
from drivers.timeline import DigitalLine, LineLevel
from tests.kit.simulated_bench import CLOCK, SWITCH, TX, Bench

BAD = (LineLevel(DigitalLine.PA_GATE, 0, TX), LineLevel(DigitalLine.RX_CONNECT, TX - 300, TX + SWITCH + 610))


@pytest.mark.parametrize("name", ["thread", "jewel"])
def test_normal_use_never_violates_the_interlock(name):
    bench = Bench(name)
    for _ in range(3):
        bench.shot(rx=6100)
    assert bench.backend.world.violations() == ()
    assert bench.truth()["violations"] == []
    assert bench.truth()["hot_switch_a"] < 1e-12


def test_receiver_on_the_live_amplifier_is_seen_with_time_and_cause_and_destroys_the_lna():
    bench = Bench("thread")
    volts = bench.shot(rx=610, lines=BAD)
    violation, *bounces = bench.backend.world.violations()
    assert violation.shot == 1
    assert violation.time_s == pytest.approx((TX - 300) / CLOCK.rate_hz + 3e-3, abs=1e-5)
    assert all("live amplifier" in v.cause for v in (violation, *bounces))
    assert bench.truth()["violations"][0]["time_s"] == violation.time_s
    assert bench.lna.overloaded()
    bench.lna.clear_overload()
    assert bench.lna.overloaded()
    for command in (bench.lna.gain, lambda: bench.lna.set_gain(10.0)):
        with pytest.raises(DeviceFault, match="destroyed"):
            command()
    assert np.abs(volts[0, TX + SWITCH :]).max() < 10 * 14e-3 * bench.calibration.sensitivity[0, 0]


def test_a_destroyed_lna_hears_nothing_until_it_is_replaced():
    bench = Bench("thread")
    bench.shot(rx=610, lines=BAD)
    assert np.abs(bench.shot(rx=610)[0, TX + SWITCH :]).max() < 0.01
    bench.backend.repair()
    assert bench.lna.gain() == 40.0
    assert np.abs(bench.shot(rx=610)[0, TX + SWITCH :]).max() > 0.1


def test_a_muted_amplifier_makes_the_same_lines_harmless():
    bench = Bench("thread")
    bench.amplifier.disable()
    bench.card.program(bench.line_up(rx=610, lines=BAD))
    bench.card.arm()
    bench.card.trigger()
    bench.card.read(10**6)
    assert bench.backend.world.violations() == ()
    assert not bench.lna.overloaded()


def test_contacts_still_moving_are_no_violation():
    early = (LineLevel(DigitalLine.PA_GATE, 0, TX), LineLevel(DigitalLine.RX_CONNECT, TX - 100, TX + SWITCH + 610))
    bench = Bench("thread")
    bench.shot(rx=610, lines=early)
    assert bench.backend.world.violations() == ()
    assert bench.truth()["hot_switch_a"] > 0.01


def test_a_violation_is_not_known_before_it_happens():
    bench = Bench("thread")
    bench.start(bench.line_up(rx=610, lines=BAD))
    bench.card.read(1000)
    assert bench.backend.world.violations() == ()
    assert not bench.lna.overloaded()
    bench.card.read(10**6)
    assert len(bench.backend.world.violations()) == 4  # one touch and three bounces
