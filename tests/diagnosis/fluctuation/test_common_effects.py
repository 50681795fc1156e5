"""Effects beside courses must be common: constant torques of the simulated world, the same or opposite in two shots."""

import pytest

from platform_daemon.diagnosis.effect_search import candidates_for, declared_fit
from platform_daemon.diagnosis.fluctuation.common_effects import common_effects
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.thread_pool import shot_pool
from platform_daemon.estimation.physics.models import THREAD
from tests.kit.undeclared_shots import shots_with


@pytest.mark.parametrize(("sizes", "common"), [((4e3, 4e3), True), ((4e3, -2e3), False)])
def test_only_what_has_one_size_in_all_shots_is_common(sizes, common):
    shots = [
        shots_with("thread", [{"id": "bias_torque", "strength": size}], 1, seed=seed, rx_s=1.0)[0][0]
        for seed, size in enumerate(sizes)
    ]
    with shot_pool() as pool:
        prepared, _ = initial_fits(shots, THREAD, pool)
        base = declared_fit(prepared, THREAD, pool)
        bias = [c for c in candidates_for(base) if c.effect.id == "bias_torque"]
        hypothesis, strengths = common_effects(base, base.states, bias, pool)
    assert [c.effect.id for c in hypothesis.common] == (["bias_torque"] if common else [])
    if common:
        assert strengths[0] == pytest.approx(4e3, rel=0.1)  # by one linear step
