"""Small samples of what `make campaign` draws in full: scatter at the bound, no bias, honest intervals, no failures."""

import numpy as np
import pytest

from tests.campaigns.estimator_statistics import Outcome, Scatter, outcomes, scatter, scatter_section, truths_row


@pytest.mark.long
@pytest.mark.parametrize("name", ["JN50", "TN50"])
def test_scatter_bias_and_coverage_of_a_short_series(name):
    assert scatter(name, 150).complaints() == []


@pytest.mark.long
@pytest.mark.parametrize("name", ["JN50", "TN50"])
def test_errors_are_honest_with_the_noise_of_the_record_itself(name):
    assert scatter(name, 100, own_noise=True).complaints() == []


@pytest.mark.parametrize("variant", ["thread", "jewel"])
@pytest.mark.parametrize("scale", [1.0, 10.0])
def test_random_resonators_are_fitted_or_called_too_faint(variant, scale):
    found = outcomes(variant, scale, "n50", 12)
    assert [o for o in found if o.failed] == []
    assert variant in truths_row(variant, scale, "n50", found)


@pytest.mark.parametrize(
    ("predicted", "reason", "joint", "failed"),
    [
        (0.01, None, 9.0, False),
        (0.01, None, 200.0, True),
        (0.01, "no_convergence: ...", 0.0, True),
        (0.01, "amplitude_below_floor: ...", 0.0, True),
        (0.04, "amplitude_below_floor: ...", 0.0, False),
        (0.06, None, 9.0, False),
        (0.5, None, 9.0, True),
        (0.5, "two_resonators: ...", 0.0, True),
        (0.5, "amplitude_below_floor: ...", 0.0, False),
    ],
)
def test_what_counts_as_a_failure(predicted, reason, joint, failed):
    assert Outcome(0, predicted, reason, joint, 9).failed == failed


@pytest.mark.parametrize(
    ("spread", "shift", "said"), [(1.0, 0.0, 1.0), (1.3, 0.0, 1.0), (1.0, 0.3, 1.0), (1.0, 0.0, 0.8)]
)
def test_too_much_scatter_bias_and_small_errors_are_complained_of(spread, shift, said):
    draws = 4000
    misses = spread * np.random.default_rng(0).standard_normal((draws, 1)) + shift
    found = Scatter("X", ("f",), np.ones(1), misses, np.full((draws, 1), said), ())
    assert (found.complaints() == []) == (spread == 1.0 and shift == 0.0 and said == 1.0)
    assert "| X | f |" in scatter_section("t", [found])
