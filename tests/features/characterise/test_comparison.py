"""N50 against D30: the tests are what they say, and the family of them errs as often as it may."""

import math

import numpy as np
import pytest
from scipy.stats import ttest_1samp, ttest_rel

from platform_daemon.features.characterise.comparison import Pairs, compare, holm

RNG = np.random.default_rng


def test_a_row_is_the_paired_t_test_of_its_shots():
    one, two = RNG(1).normal(size=(2, 40))
    (row,) = compare([Pairs("f_nat_hz", one, two)], 0.01)
    found = ttest_rel(one, two)
    assert row.p_value == pytest.approx(found.pvalue)
    interval = found.confidence_interval(0.99)
    assert (row.low, row.high) == pytest.approx((interval.low, interval.high))
    assert row.difference == pytest.approx(np.mean(one - two))


def test_what_both_windows_share_does_not_hide_a_difference():
    shared = 100.0 * RNG(2).normal(size=50)
    one, two = shared + 0.1 * RNG(3).normal(size=(2, 50))
    (equal, differs) = compare([Pairs("f_nat_hz", one, two), Pairs("m_r_am2", one + 0.2, two)], 0.001)
    assert not equal.significant
    assert differs.significant
    assert differs.difference == pytest.approx(0.2, abs=0.1)


def test_phases_are_compared_the_shorter_way_round():
    two = (0.02 * RNG(4).normal(size=30)) % (2 * math.pi)
    (row,) = compare([Pairs("psi_start_rad", (two + 0.1) % (2 * math.pi), two, circular=True)], 0.001)
    assert row.difference == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("pairs", "said"),
    [
        (Pairs("lambda_per_s", reason="held at 0.2 in N50"), "held at 0.2"),
        (Pairs("f_nat_hz", [1.0], [2.0]), "1 of the 2 shots"),
        (Pairs("f_nat_hz"), "0 of the 2 shots"),
        (Pairs("f_nat_hz", [1.0, 2.0, 3.0], [1.0, 2.0, 3.0]), "same in all shots"),
        (Pairs("f_nat_hz", [1.5, 2.5, 3.5], [1.0, 2.0, 3.0]), "same in all shots"),
    ],
)
def test_what_cannot_be_tested_says_why_and_does_not_count(pairs, said):
    tested = Pairs("m_r_am2", *RNG(5).normal(size=(2, 20)))
    first, second = compare([pairs, tested], 0.001)
    assert said in first.reason
    assert first.p_value is first.p_adjusted is first.significant is first.low is None
    assert second.p_adjusted == second.p_value


def test_holm_is_the_step_down_of_bonferroni():
    # Holm's rule by hand: sorted 0.01, 0.02, 0.03, 0.04 times 4, 3, 2, 1, never falling.
    assert holm([0.04, 0.01, 0.03, 0.02]) == pytest.approx([0.06, 0.04, 0.06, 0.06])
    assert holm([0.9, 0.8]) == [1.0, 1.0]
    assert holm([]) == []


def test_no_quantity_is_called_different_more_often_than_said():
    random, alpha, families = RNG(6), 0.05, 2000
    common = random.normal(size=(12, families, 1))
    p_values = ttest_1samp(0.7 * common + random.normal(size=(12, families, 6)), 0.0).pvalue  # they go together
    share = np.mean([min(holm(family)) < alpha for family in p_values])
    assert 0.5 * alpha < share < alpha + 3.0 * math.sqrt(alpha * (1.0 - alpha) / families)


def test_shots_that_depend_on_each_other_are_seen():
    drift = np.cumsum(RNG(7).normal(size=100))
    free = RNG(8).normal(size=100)
    drifting, independent = compare([Pairs("a", drift, np.zeros(100)), Pairs("b", free, np.zeros(100))], 0.001)
    assert drifting.lag_one_correlation > 0.8
    assert abs(independent.lag_one_correlation) < 0.3
