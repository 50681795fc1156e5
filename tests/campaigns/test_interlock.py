"""A tenth of `make interlock`: nothing breaks, and each planted mistake is found."""

import pytest

from tests.campaigns.interlock.campaign import run
from tests.campaigns.interlock.mutants import MUTANTS


@pytest.mark.long
def test_power_never_meets_the_receiver_whatever_is_done_in_whatever_order():
    found = run(10_000, number=100)
    assert found.why == ""
    assert found.steps >= 10_000
    assert {step for step, _ in found.visits} >= {"shot", "rescue", "restart", "shot with a loose line", "trip"}


@pytest.mark.long
@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant.name)
def test_a_planted_mistake_is_found(mutant):
    assert run(10_000, number=200, mutant=mutant).why
