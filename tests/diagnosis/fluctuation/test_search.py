"""What fluctuates in the simulated world, from the shots to its name."""

from dataclasses import replace

import pytest

from platform_daemon.diagnosis.diagnose import diagnose_shots
from platform_daemon.diagnosis.effect_search import candidates_for, declared_fit
from platform_daemon.diagnosis.fluctuation.first_look import differs_from_shot_to_shot
from platform_daemon.diagnosis.fluctuation.flat_noise import with_flat_noise
from platform_daemon.diagnosis.fluctuation.fluctuating import what_may_fluctuate
from platform_daemon.diagnosis.fluctuation.search import fluctuation_of
from platform_daemon.diagnosis.fluctuation_diagnosis import fitted_shots
from platform_daemon.diagnosis.report import diagnosis_report
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.thread_pool import shot_pool
from platform_daemon.estimation.physics.models import JEWEL
from tests.kit.undeclared_shots import shots_with

FLUCTUATION = {"id": "friction_fluctuation", "strength": 0.2, "tau_s": 0.1}
WANDERING = {"id": "frequency_fluctuation", "strength": 0.17, "tau_s": 0.12}
FRICTION, FREQUENCY = what_may_fluctuate(JEWEL)
GAIN = {"id": "channel_gain", "strength": -0.034, "axis": "y"}


@pytest.fixture(scope="module")
def wounded():
    """Shots with both, and their truths."""
    return shots_with("jewel", [FLUCTUATION, GAIN], 2)


def test_courses_are_found_beside_an_effect_of_the_receiver(wounded):
    shots, truths = wounded
    with shot_pool() as pool:
        prepared, _ = initial_fits(shots, JEWEL, pool)
        base = declared_fit(prepared, JEWEL, pool)
        found = fluctuation_of(base, FRICTION, candidates_for(base), pool)
    assert base.chi2_per_dof > 100.0
    assert found is not None
    (gain,) = found.joint_fit.hypothesis.effects
    assert gain.effect.id == "channel_gain"
    assert found.joint_fit.chi2_per_dof == pytest.approx(1.0, abs=0.05)
    assert found.likeliest.process.size == pytest.approx(0.2, rel=3.0 * found.likeliest.log_size_std)
    for state, truth in zip(found.joint_fit.states, truths, strict=True):
        # The gain of y is told from one of x by nothing, so that the moment is that of either.
        assert state.observation.m_r == pytest.approx(truth["m_r_am2"], rel=0.04)


@pytest.mark.parametrize(
    "effect",
    [{"id": "angle_dependent_damping", "strength": 0.5}, {"id": "memory_relaxation", "strength": 0.02, "tau_s": 0.02}],
    ids=lambda effect: effect["id"],
)
def test_a_law_that_all_shots_have_in_common_is_no_fluctuation(effect):
    shots, _ = shots_with("jewel", [effect], 2)
    with shot_pool() as pool:
        prepared, _ = initial_fits(shots, JEWEL, pool)
        base = declared_fit(prepared, JEWEL, pool)
        assert not differs_from_shot_to_shot(base, FRICTION, pool)
        assert not differs_from_shot_to_shot(base, FREQUENCY, pool)


@pytest.mark.long
def test_the_report_names_it_and_both_windows_agree_afterwards():
    shots, truths = shots_with("jewel", [FLUCTUATION, GAIN], 2)
    report = diagnosis_report(diagnose_shots(shots, JEWEL))
    assert report.verdict == "explained"
    assert [e.id for e in report.effects] == ["friction_fluctuation", "channel_gain"]
    share = report.effects[0].strength
    assert share.value == pytest.approx(0.2, abs=3.0 * share.std)
    assert 0.03 < report.effects[0].detail.tau_s < 0.3
    assert 0.1 < report.effects[0].detail.std["tau_s"] / report.effects[0].detail.tau_s < 1.0
    assert report.held_out.chi2_per_dof_after < 1.3
    after = report.parameters_after
    friction = sum(t["tf_over_i_rad_per_s2"] for t in truths) / len(truths)
    assert after["tf_over_i_rad_per_s2"].value == pytest.approx(friction, abs=3.0 * after["tf_over_i_rad_per_s2"].std)
    loss = truths[0]["lambda_per_s"]
    assert after["lambda_per_s"].value == pytest.approx(loss, abs=3.0 * after["lambda_per_s"].std)
    for name in ("f_nat_hz", "lambda_per_s", "tf_over_i_rad_per_s2", "m_r_am2"):
        assert report.n50_d30[name].after_sigma < 4.0
    assert any("fluctuates" in note for note in report.notes)


@pytest.mark.long
def test_courses_of_the_frequency_are_found_beside_an_effect_of_the_receiver():
    shots, truths = shots_with("jewel", [WANDERING, GAIN], 2, rx_s=0.5)
    with shot_pool() as pool:
        prepared, _ = initial_fits(shots, JEWEL, pool)
        # What is measured between the harmonics holds a part of the fluctuation.
        base = declared_fit(with_flat_noise(prepared) or prepared, JEWEL, pool)
        assert base.chi2_per_dof > 20.0
        few = replace(FREQUENCY, knots=80)  # enough for so short a window
        found = fluctuation_of(base, few, candidates_for(base), pool)
    assert found is not None
    assert found.joint_fit.chi2_per_dof == pytest.approx(1.0, abs=0.06)
    assert found.likeliest.process.size == pytest.approx(0.17, rel=3.0 * found.likeliest.log_size_std)
    assert found.likeliest.log_size_std < 0.6
    for state, truth in zip(found.joint_fit.states, truths, strict=True):
        assert state.observation.m_r == pytest.approx(truth["m_r_am2"], rel=0.04)


@pytest.mark.campaign
def test_a_frequency_that_fluctuates_is_told_from_a_friction():
    shots, truths = shots_with("jewel", [WANDERING, GAIN], 2, rx_s=1.2)
    report = diagnosis_report(diagnose_shots(shots, JEWEL))
    assert report.verdict == "explained"
    assert [e.id for e in report.effects] == ["frequency_fluctuation", "channel_gain"]
    size = report.effects[0].strength
    assert size.unit == "Hz"
    assert size.std < 0.1
    assert size.value == pytest.approx(0.17, abs=3.0 * size.std)
    assert 0.04 < report.effects[0].detail.tau_s < 0.4
    assert report.held_out.chi2_per_dof_after < 1.3
    after = report.parameters_after
    for name in ("f_nat_hz", "lambda_per_s", "tf_over_i_rad_per_s2"):
        truth = sum(t[name] for t in truths) / len(truths)
        assert after[name].value == pytest.approx(truth, abs=3.0 * after[name].std)
        assert report.n50_d30[name].after_sigma < 4.0
    assert any("the natural frequency fluctuates" in note for note in report.notes)


@pytest.mark.long
def test_stribeck_friction_keeps_its_name():
    shots, _ = shots_with("jewel", [{"id": "stribeck_friction", "strength": 0.3, "v_s_rad_per_s": 100.0}], 3)
    report = diagnosis_report(diagnose_shots(shots, JEWEL))
    assert not {"friction_fluctuation", "frequency_fluctuation"} & {e.id for e in report.effects}


def test_of_a_long_series_the_courses_of_twelve_shots_are_fitted():
    assert (FRICTION.most_shots, FREQUENCY.most_shots) == (12, 4)
    assert fitted_shots(list(range(100)), 12) == [0, 9, 18, 27, 36, 45, 54, 63, 72, 81, 90, 99]
    assert fitted_shots([7, 8], 12) == [7, 8]
