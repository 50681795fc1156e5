"""The score is that of the page, and its floor that of anybody's least squares; the peers themselves are not needed."""

import math

import numpy as np
import pytest

from tests.benchmarks.peers import simulated, weak_form
from tests.benchmarks.peers.columns import LIBRARY, effects_named, model_of
from tests.benchmarks.peers.datasets import Record, angle_record, measured, split_in_time, write_angles
from tests.benchmarks.peers.ours import said
from tests.benchmarks.peers.page import document, false, missed
from tests.benchmarks.peers.routes import Row
from tests.benchmarks.peers.score import score, simulate
from tests.benchmarks.peers.sindy import scaled_states
from tests.benchmarks.peers.viscous import fit_declared

W = 8.0


def pendulum(seconds: float, zero: float = 0.02, **losses: float) -> Record:
    time_s = np.arange(0.0, seconds, 2e-3)
    motion = simulate(model_of({"sine": W**2, **losses}, 8.0), 1.0, 0.0, time_s)
    return Record("made", time_s, motion.phi[None] + zero)


@pytest.mark.long
def test_the_floor_of_r1_is_that_of_others():
    task = measured()["r1"]
    found = score(fit_declared(task), task)
    assert found.held_out == pytest.approx(0.215, rel=0.03)
    assert found.train == pytest.approx(0.0128, rel=0.03)


def test_the_floor_across_runs_is_that_of_others():
    task = measured()["r2"]
    assert score(fit_declared(task), task).held_out == pytest.approx(0.294, rel=0.03)


def test_a_true_model_is_scored_as_nothing_missing_and_a_wrong_one_is_not():
    task = split_in_time("made", pendulum(12.0, viscous_damping=0.05, coulomb_friction=0.3))
    true = model_of({"sine": W**2, "viscous_damping": 0.05, "coulomb_friction": 0.3}, 8.0)
    assert score(true, task).held_out < 1e-4
    assert score(model_of({"sine": W**2, "viscous_damping": 0.05}, 8.0), task).held_out > 0.1


def test_the_floor_finds_what_is_there():
    task = split_in_time("made", pendulum(10.0, viscous_damping=0.05))
    assert fit_declared(task).terms == pytest.approx({"sine": W**2, "viscous_damping": 0.05}, rel=1e-4)


def test_a_friction_holds_the_pendulum():
    motion = simulate(model_of({"sine": W**2, "coulomb_friction": 20.0}, 8.0), 0.2, 0.0, np.linspace(0.0, 5.0, 50))
    assert motion.phi == pytest.approx(0.2, abs=1e-2)


def test_what_runs_away_is_not_followed():
    run = simulate(model_of({"sine": W**2, "viscous_damping": -5.0}, 8.0), 0.2, 0.0, np.linspace(0.0, 20.0, 200))
    assert np.isnan(run.phi).all()


def test_the_model_of_a_report_is_what_it_says():
    task = split_in_time("made", pendulum(4.0))
    detail = dict.fromkeys(("axis", "frequency_hz", "tau_s", "sample", "from", "to"))

    def effect(name, strength, *alike, **where):
        found = {"id": name, "strength": {"value": strength}, "indistinguishable_from": list(alike)}
        return found | {"detail": detail | where}

    before = {"f_nat_hz": {"value": 1.0}, "lambda_per_s": {"value": 0.1}}
    after = {"f_nat_hz": {"value": 2.0}, "lambda_per_s": {"value": 0.2}}
    report = {"verdict": "explained", "parameters_before": before, "parameters_after": after, "effects": []}
    plain = said(report, task)
    assert plain.model.terms == pytest.approx({"sine": (2 * math.pi) ** 2, "viscous_damping": 0.1})
    effects = [
        effect("quadratic_drag", 0.01, "cubic_drag"),
        effect("clock_gap", 5.0, sample=100),
        effect("side_mode", 1),
    ]
    full = said(report | {"effects": effects}, task)
    assert full.model.terms == pytest.approx(
        {"sine": (4 * math.pi) ** 2, "viscous_damping": 0.2, "quadratic_drag": 0.01}
    )
    assert full.model.gaps == ((pytest.approx(0.2), pytest.approx(0.01)),)
    assert full.named == ("quadratic_drag", "clock_gap", "side_mode")
    assert full.alike == ("cubic_drag",)
    assert full.remark == "not simulated: side_mode"
    drift = said(report | {"effects": [effect("frequency_drift", 0.2)]}, task).model
    assert drift.torque(1.0, 0.0, 1.0) == pytest.approx(-((4 * math.pi) ** 2) * 1.1**2 * math.sin(1.0))


def test_names_and_signs_are_counted():
    model = model_of({"sine": 1.0, "viscous_damping": -1.0, "cubic_restoring": 2.0, "coulomb_friction": 0.0}, 1.0)
    assert model.unphysical() == ("viscous_damping",)
    assert effects_named(model.terms, ("viscous_damping",)) == ("restoring_anharmonicity",)
    row = Row("ours", "s00", 0.1, 0.1, ("angle_dependent_damping", "bias_torque"), ("quadratic_drag",))
    assert missed(row, ["quadratic_drag"]) == []
    assert false(row, ["quadratic_drag"]) == ["bias_torque"]
    assert missed(row, ["coulomb_friction"]) == ["coulomb_friction"]
    assert len(false(row, ["coulomb_friction"])) == 2


def test_the_page_has_every_row_and_setting():
    rows = [Row("ours", "r1", 0.01, 0.02), Row("ours", "s00", None, None, remark="exit 3: refused")]
    page = document([*rows, Row("viscous floor", "s00", 0.1, math.inf)])
    assert "| ours | 0.01 | 0.02 |" in page
    assert "diverges" in page
    assert "exit 3: refused" in page
    assert "threshold=0.001" in page
    assert "Not complete" in page


def test_training_parts_are_written_as_the_product_reads_them(tmp_path):
    made = pendulum(1.0)
    back = angle_record(write_angles(made, tmp_path / "made.h5"))
    assert np.array_equal(back.signal, made.signal)
    assert back.rate_hz == pytest.approx(500.0)


def test_hidden_effects_are_drawn_by_seed_and_every_kind_occurs():
    found = [simulated.drawn(k) for k in range(20)]
    assert found == [simulated.drawn(k) for k in range(20)]
    assert {name for _, name, _ in found} == {*simulated.VISIBLE["thread"], simulated.NOTHING}
    assert all((strength == 0.0) == (name == simulated.NOTHING) for _, name, strength in found)


def test_the_weak_form_balances_the_energy_of_a_clean_record():
    task = split_in_time("made", pendulum(30.0, 0.0, viscous_damping=0.02, coulomb_friction=0.15))
    states = [np.concatenate(part) for part in zip(*scaled_states(task, W), strict=True)]
    (_, _), (columns, work) = weak_form.rows(*states)
    # In units of 1/w: sine 1, damping 0.02/w, friction 0.15/w^2.
    expected = dict.fromkeys(LIBRARY, 0.0) | {"sine": 1.0, "viscous_damping": 0.02 / W, "coulomb_friction": 0.15 / W**2}
    assert columns @ np.array(list(expected.values())) == pytest.approx(work, abs=2e-3 * np.abs(work).max())
