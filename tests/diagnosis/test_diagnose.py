"""From shots with an effect that nobody declared to its name, its strength and the proof."""

import json
from dataclasses import replace

import numpy as np
import pytest

from platform_daemon.diagnosis.diagnose import DiagnosisError, diagnose_shots
from platform_daemon.diagnosis.effect_search import candidates_for
from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.joint_fit import fit_jointly
from platform_daemon.diagnosis.regression.score_test import score_table
from platform_daemon.diagnosis.regression.torque_response import torque_responses
from platform_daemon.diagnosis.report import diagnosis_report
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.thread_pool import shot_pool
from platform_daemon.estimation.moments.workspace import Workspace
from platform_daemon.estimation.physics.models import JEWEL, THREAD, model_named
from platform_daemon.estimation.physics.trajectory.direct import Trajectory
from tests.kit.undeclared_shots import shots_with


def found(variant, *undeclared, **more):
    shots, truths = shots_with(variant, undeclared, **more)
    return diagnosis_report(diagnose_shots(shots, model_named(variant))).model_dump(mode="json"), truths


def names(report):
    """Of every effect: its id and those it cannot be told from."""
    return [{e["id"], *e["indistinguishable_from"]} for e in report["effects"]]


@pytest.mark.parametrize("variant", ["thread", "jewel"])
def test_nothing_is_missing_in_clean_shots(variant):
    report, _ = found(variant)
    assert report["verdict"] == "nothing_missing"
    assert report["effects"] == []
    assert report["parameters_before"] == report["parameters_after"]


def long(*case):
    """A case that only the campaign runs."""
    return pytest.param(*case, marks=pytest.mark.campaign)


@pytest.mark.parametrize(
    ("variant", "effect"),
    [
        ("thread", {"id": "coulomb_friction", "strength": 1.0}),
        long("thread", {"id": "torsion_stiffness", "strength": 0.01}),
        long("thread", {"id": "frequency_drift", "strength": 3e-3}),
        long("jewel", {"id": "quadratic_drag", "strength": 3e-5}),
        long("jewel", {"id": "bias_torque", "strength": 2500.0}),
        long("jewel", {"id": "crosstalk", "strength": 1e-3, "from": "x", "to": "y"}),
        pytest.param(*("jewel", {"id": "receiver_compression", "strength": 3e-3, "axis": "x"}), marks=pytest.mark.long),
        long("jewel", {"id": "receive_lowpass", "strength": 1.5e-5}),
        pytest.param(
            *("jewel", {"id": "side_mode", "strength": 0.02, "frequency_hz": 171.3, "tau_s": 0.2, "axis": "z"}),
            marks=pytest.mark.long,
        ),
        long("jewel", {"id": "switch_transient", "strength": 0.05, "tau_s": 0.01, "axis": "x"}),
        long("thread", {"id": "spectral_line", "strength": 2e-3, "frequency_hz": 737.3}),
        long(
            "thread", {"id": "mains_interference", "strength": 3e-3, "frequency_hz": 50.0, "harmonics": [1.0, 0.0, 0.5]}
        ),
    ],
)
def test_an_undeclared_effect_is_named_or_among_its_look_alikes(variant, effect):
    report, _ = found(variant, effect)
    assert report["verdict"] == "explained", report["notes"]
    assert len(report["effects"]) == 1
    assert effect["id"] in names(report)[0]
    first = report["effects"][0]
    assert first["p_value"] < 1e-3
    assert first["held_out_gain"] > 0.0
    assert report["held_out"]["chi2_per_dof_after"] == pytest.approx(1.0, abs=0.03)
    if first["id"] == effect["id"] and len(names(report)[0]) == 1 and "axis" not in effect:
        assert abs(first["strength"]["value"] - effect["strength"]) < 4.5 * first["strength"]["std"]
    json.dumps(report, allow_nan=False)


@pytest.mark.campaign
def test_parameters_are_right_once_the_effect_is_in_the_model():
    report, truths = found("thread", {"id": "quadratic_drag", "strength": 1e-4}, rx_s=3.0)
    assert names(report)[0] >= {"quadratic_drag"}
    truth = truths[0]
    for name in ("f_nat_hz", "lambda_per_s", "m_r_am2"):
        after = report["parameters_after"][name]
        assert abs(after["value"] - truth[name]) < 4.5 * after["std"] + 1e-9 * truth[name]
    before = report["parameters_before"]["lambda_per_s"]
    assert abs(before["value"] - truth["lambda_per_s"]) > 20.0 * before["std"]


@pytest.mark.campaign
def test_two_effects_that_hide_each_other_are_both_named():
    drag, mix = (
        {"id": "bias_torque", "strength": 1500.0},
        {"id": "crosstalk", "strength": 4.5e-4, "from": "x", "to": "y"},
    )
    report, _ = found("jewel", drag, mix, seed=11)
    together = set().union(*names(report))
    assert {"bias_torque", "crosstalk"} <= together
    assert len(report["effects"]) == 2


@pytest.mark.campaign
@pytest.mark.parametrize(
    ("variant", "pose", "effect"),
    [
        ("jewel", None, {"id": "memory_amplitude", "strength": 1e-3, "tau_s": 0.1}),
        ("jewel", None, {"id": "memory_relaxation", "strength": 3e-4, "tau_s": 0.02}),
        ("thread", (0.6, -0.3, -1.1), {"id": "memory_amplitude", "strength": 1e-3, "tau_s": 0.1}),
    ],
)
def test_what_has_no_name_is_never_explained(variant, pose, effect):
    report, _ = found(variant, effect, pose=pose, seed=196)
    assert report["verdict"] in ("unexplained", "partly_explained")
    torque = report["missing_torque"]
    assert np.array(torque["value"], dtype=float).shape == (len(torque["phi"]), len(torque["phi_dot"]))
    assert report["next_measurements"]


@pytest.mark.long
def test_lost_samples_are_a_flaw_of_the_data_and_not_physics():
    report, _ = found("jewel", {"id": "clock_gap", "strength": 3, "sample": 30000})
    assert {i["id"] for i in report["integrity"]} == {"clock_gap"}
    assert [(e["id"], e["detail"]["sample"]) for e in report["effects"]] == [("clock_gap", 30000)]
    assert round(report["effects"][0]["strength"]["value"]) == 3
    assert report["verdict"] == "explained"


@pytest.mark.long
def test_friction_that_differs_from_shot_to_shot_is_scatter():
    report, _ = found("jewel", count=5, effects__friction_scatter__relative_sd=0.5)
    assert report["verdict"] == "nothing_missing"
    friction = report["parameters_after"]["tf_over_i_rad_per_s2"]
    assert report["scatter"]["tf_over_i_rad_per_s2"] > 20.0 * friction["std"]


def test_one_shot_is_split_in_time_and_says_so():
    report, _ = found("thread", {"id": "quadratic_drag", "strength": 1e-4}, count=1)
    assert report["held_out"]["n_shots"] == 1
    assert any("one shot only" in n for n in report["notes"])
    assert "quadratic_drag" in names(report)[0]


def test_copies_of_a_shot_are_reported_and_left_out():
    shots, _ = shots_with("jewel", count=3)
    report = diagnosis_report(diagnose_shots([*shots, replace(shots[0], name="again")], JEWEL)).model_dump(mode="json")
    assert [i["id"] for i in report["integrity"]] == ["duplicated_shot"]
    assert report["held_out"]["n_shots"] == 3


def test_shots_without_a_signal_are_refused_with_the_reason():
    shots, _ = shots_with("thread", count=2)
    rng = np.random.default_rng(3)
    mute = [replace(s, record=replace(s.record, samples=rng.normal(0.0, 0.02, s.record.samples.shape))) for s in shots]
    with pytest.raises(DiagnosisError, match="no_signal"):
        diagnose_shots(mute, THREAD)


def test_the_basis_from_tables_is_that_of_the_direct_path():
    shots, _ = shots_with("jewel", count=1)
    with shot_pool() as pool:
        prepared, _ = initial_fits(shots, JEWEL, pool)
    d, dt_s = prepared[0].state.dynamics, 1.0 / shots[0].rate_hz
    fast = Workspace(JEWEL).basis(d, 100, 60000, dt_s, 0)
    exact = Trajectory(JEWEL, d, 60000 * dt_s).basis(100, 60000, dt_s, 0)
    size = np.max(np.abs(exact), axis=1, keepdims=True)
    assert np.max(np.abs(fast - exact) / size) < 1e-7


@pytest.mark.parametrize("model", [THREAD, JEWEL])
def test_the_answer_to_any_torque_agrees_with_the_derivative_of_a_known_one(model):
    shots, _ = shots_with(model.name, count=1)
    with shot_pool() as pool:
        prepared, _ = initial_fits(shots, model, pool)
        at = fit_jointly(prepared, Hypothesis(model), pool)
    linear, w = at.linear[0], at.states[0].dynamics.w
    answer = torque_responses(prepared[0], model, at.states[0], lambda phi, v: (-2.0 * v)[None])
    column = prepared[0].white(answer)[0]
    place = 3 + [c.name for c in model.coefficients].index("lambda_per_s")
    # A lambda of 1/s is a damping of 1/w; both begin at different times, which the shot's own parameters take up.
    assert np.linalg.norm(linear.without_own(column)) < 1e-3 * np.linalg.norm(column)
    assert np.linalg.norm(column) == pytest.approx(w * np.linalg.norm(linear.base()[:, place]), rel=0.1)


def test_a_refit_follows_a_bent_valley_to_its_end():
    """A bias torque turns the orientation by hundreds of its standard deviations: single steps there go up."""
    shots, _ = shots_with("thread", [{"id": "bias_torque", "strength": 4000.0}], count=2)
    with shot_pool() as pool:
        prepared, _ = initial_fits(shots, THREAD, pool)
        base = fit_jointly(prepared, Hypothesis(THREAD), pool)
        bias = [c for c in candidates_for(base) if c.effect.id == "bias_torque"]
        seen = score_table(base, bias, pool)
        expected = seen.gain([seen.blocks[0]])
        at = fit_jointly(prepared, base.hypothesis.plus(*bias), pool, base.states)
    assert base.chi2 - at.chi2 == pytest.approx(expected.gain * base.noise_factor, rel=0.02)
    assert at.strengths[0] == pytest.approx(4000.0, abs=4.5 * expected.sd[0])
    assert np.sqrt(at.covariance[0, 0]) == pytest.approx(expected.sd[0], rel=0.05)
