"""What a planned measurement is expected to bring, against the measurement itself."""

import numpy as np
import pytest

from platform_daemon.diagnosis.effect_search import candidates_for
from platform_daemon.diagnosis.findings.experiment_design import discrimination
from platform_daemon.diagnosis.findings.next_measurements import Ambiguity, proposals
from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.joint_fit import fit_jointly
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.thread_pool import shot_pool
from platform_daemon.estimation.physics.models import THREAD
from tests.kit.undeclared_shots import shots_with

DRAG = {"id": "quadratic_drag", "strength": 4e-5}


def candidate(at, name):
    return next(c for c in candidates_for(at) if c.effect.id == name)


def rise(shots, pool):
    """Of chi^2 with angle-dependent damping in the place of quadratic drag."""
    prepared, _ = initial_fits(shots, THREAD, pool)
    base = fit_jointly(prepared, Hypothesis(THREAD), pool)
    fits = [
        fit_jointly(prepared, base.hypothesis.plus(candidate(base, name)), pool, base.states)
        for name in ("quadratic_drag", "angle_dependent_damping")
    ]
    return fits[1].chi2 - fits[0].chi2, fits[0]


@pytest.fixture(scope="module")
def pool():
    with shot_pool() as pool:
        yield pool


@pytest.fixture(scope="module")
def present():
    return shots_with("thread", [DRAG], count=2)[0]


@pytest.fixture(scope="module")
def at(present, pool):
    return rise(present, pool)[1]


def test_a_longer_window_brings_what_was_expected_of_it(present, at, pool):
    rival = candidate(at, "angle_dependent_damping")
    (expected,) = discrimination(at, at.hypothesis.common[0], [rival], "longer_window", pool)
    longer, _ = shots_with("thread", [DRAG], count=2, rx_s=4.0, seed=2)
    found, _ = rise([*present, *longer], pool)
    assert found == pytest.approx(expected**2, abs=6.0 * expected + 0.1 * expected**2)
    assert expected**2 > 1.5 * rise(present, pool)[0]


def test_repeating_the_shots_grows_as_their_number(at, pool):
    rival = candidate(at, "angle_dependent_damping")
    (more,) = discrimination(at, at.hypothesis.common[0], [rival], "more_shots", pool)
    (other,) = discrimination(at, at.hypothesis.common[0], [rival], "turn_90_deg", pool)
    # Torques do not care how the resonator lies: a turned series is one more of the same, in channels of other noise.
    assert more == pytest.approx(np.sqrt(2.0) * other, rel=0.25)


def test_what_cannot_be_planned_is_judged_by_a_rule_of_thumb(at, pool):
    assert discrimination(at, at.hypothesis.common[0], [], "calibrate_2f", pool) is None


def test_the_measurement_that_separates_most_comes_first_and_angles_have_their_own_words(at):
    drag, damping = at.hypothesis.common[0], candidate(at, "angle_dependent_damping")
    expected = {"second_amplitude": [3.0], "longer_window": [9.0], "more_shots": [4.0]}
    one = Ambiguity(effect=drag, confounders=(damping,), rise=2.0, gain=400.0, expected=expected.get)
    offered = proposals([one], 0.0)
    assert [p.measurement.key for p in offered][:2] == ["longer_window", "more_shots"]
    assert offered[0].separates == ("quadratic_drag", "angle_dependent_damping")
    words = [p.measurement.what for p in proposals([one], 10.0, dipole=False)]
    assert "repeat the series with half the amplitude" in words
    assert not any("field" in w or "RX" in w or "turn" in w for w in words)
