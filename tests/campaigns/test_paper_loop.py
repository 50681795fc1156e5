"""The campaign on drawn effects can tell a right diagnosis from a wrong one."""

import numpy as np
import pytest

from tests.campaigns.paper_loop import diagnosed_resonator, drawn_effects


@pytest.mark.parametrize("variant", ["jewel", "thread"])
def test_effects_differ_and_are_those_of_their_bearing(variant):
    effects = [drawn_effects(variant, np.random.default_rng(seed)) for seed in range(20)]
    first = {w[0]["id"] for w in effects}
    assert first == ({"friction_fluctuation"} if variant == "jewel" else {"frequency_drift", "coulomb_friction"})
    assert {len(w) for w in effects} == {1, 2}
    assert len({w[0]["strength"] for w in effects}) == 20


@pytest.mark.campaign
def test_a_jewel_with_a_effect_is_judged():
    row = diagnosed_resonator("jewel", 1, 2)
    assert row.named
    assert row.agrees
    assert "agrees 1" in row.text()
