"""Results that no resonator has: a unit of the file was another one than it seemed."""

from __future__ import annotations

import numpy as np
import pytest

from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.goodness_of_fit.plausibility import plausibility_warnings
from platform_daemon.estimation.parameters import Estimate
from platform_daemon.estimation.record import RingDownRecord


@pytest.mark.parametrize(
    ("quantity", "f_nat_hz", "m_r_am2", "words"),
    [
        ("dmdt", 213.0, 0.0146, []),
        ("dmdt", 2.1e-4, 0.0146, ["f_nat is 0.00021 Hz", "unit of the time, or of baseFrequency"]),
        ("dmdt", 213.0, 12e3, ["m_r is 1.2e+04 A m²", "sensitivity"]),
        ("angle", 0.8, None, []),
        ("angle", 8e-4, None, ["f_nat is 0.0008 Hz", "time column"]),
    ],
)
def test_what_lies_outside_of_all_resonators_is_warned_of(quantity, f_nat_hz, m_r_am2, words):
    found = {"f_nat_hz": Estimate(f_nat_hz, 1e-9)}
    if m_r_am2 is not None:
        found["m_r_am2"] = Estimate(m_r_am2, 1e-9)
    warnings = plausibility_warnings(quantity, found)
    assert len(warnings) == bool(words)
    assert all(word in warnings[0] for word in words)


def test_what_was_held_is_not_doubted():
    assert plausibility_warnings("dmdt", {"f_nat_hz": Estimate(1e-4, None)}) == ()


def test_a_clock_in_mhz_without_a_unit_is_seen_in_the_fit():
    t = np.arange(12_000) / 200.0
    angle = 0.3 * np.exp(-0.03 * t) * np.cos(2 * np.pi * 0.8 * t)
    noisy = angle + np.random.default_rng(0).normal(0, 1e-3, t.size)
    slow, right = (fit_ring_down(RingDownRecord(noisy[None], rate, "angle"), "thread") for rate in (0.2, 200.0))
    assert any("implausible: f_nat" in each for each in slow.warnings)
    assert not any("implausible" in each for each in right.warnings)
