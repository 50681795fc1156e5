import json
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from drivers.errors import ConfigError
from sim_backend.rotor.rotor import rotation_matrix
from sim_backend.world.shot import next_leg, simulate
from sim_backend.world.side_motion import VISIBLE_AM2_PER_S, true_dm_dt, z_residual
from sim_backend.world.truth import record
from tests.kit.side_modes import changed, threshold_ut
from tests.kit.simulated_bench import CLOCK, QUIET, Bench, specimen

RX = 24414  # 0.4 s
LAZY = """
import sys
from tests.kit.side_modes import changed, threshold_ut
from tests.kit.simulated_bench import Bench
bench = Bench("jewel")
bench.shot(rx=610)
print(bench.truth()["rotor_model"], sum("rigid_body" in name for name in sys.modules))
"""


def still(name, field_t, **changes):
    bench = Bench(name, **QUIET, **changes)
    return bench, bench.shot(field_t, rx=RX)


def calibrated(bench, volts):
    """dm/dt (3, n) of the RX window from the recorded volts, the flat way."""
    setup, _ = bench.backend.world.shot_simulator.result()
    return -np.linalg.inv(setup.lna_gain * setup.sensitivity_t_per_a) @ volts[:, setup.timeline.rx_start :]


@pytest.mark.parametrize(
    ("name", "below_t", "above_t"), [("thread_imperfect", 250e-6, 300e-6), ("jewel_imperfect", 580e-6, 620e-6)]
)
def test_side_modes_show_in_truth_and_in_the_recorded_z_channel_above_the_papers_threshold_only(name, below_t, above_t):
    for field_t, visible in ((below_t, False), (above_t, True)):
        bench, volts = still(name, field_t)
        truth = bench.truth()
        assert truth["side_modes_visible"] is visible
        assert (truth["z_residual_am2_per_s"] > VISIBLE_AM2_PER_S) is visible
        received = np.abs(z_residual(calibrated(bench, volts)))
        assert received.max() == pytest.approx(truth["z_residual_am2_per_s"], rel=0.02)


def test_the_shipped_thresholds_are_the_papers_and_move_with_defect_and_damping():
    assert threshold_ut(changed("thread_imperfect"), (260, 266, 274)) == 274
    assert threshold_ut(changed("jewel_imperfect"), (580, 590, 604)) == 604
    assert threshold_ut(changed("thread_imperfect", side_damping=15.0), (220, 230, 240, 250)) is not None
    assert threshold_ut(changed("jewel_imperfect", tilt_deg=1.0), (490, 610)) is None


def test_true_dm_dt_is_what_an_ideal_receiver_records():
    bench, volts = still("thread_imperfect", 280e-6)
    truth = true_dm_dt(*bench.backend.world.shot_simulator.result())
    assert truth.shape == (3, RX)
    assert calibrated(bench, volts) == pytest.approx(truth, abs=2e-3)


def test_truth_of_an_imperfect_resonator_is_plain_json_and_names_its_modes():
    bench, _ = still("thread_imperfect", 215e-6)
    truth = bench.truth()
    assert json.loads(json.dumps(truth, allow_nan=False)) == truth
    assert truth["rotor_model"] == "rigid_body"
    assert truth["main_mode_hz"] == pytest.approx(215.69, abs=0.005)
    assert truth["main_mode_hz"] != truth["f_nat_hz"]
    assert truth["main_mode_decay_per_s"] == pytest.approx(0.2465, abs=5e-4)
    assert len(truth["side_modes_hz"]) == len(truth["side_modes_decay_per_s"]) == 4


def test_truth_of_a_single_axis_rotor_says_that_it_has_no_side_modes():
    bench, _ = still("thread", 280e-6)
    truth = bench.truth()
    assert (truth["rotor_model"], truth["side_modes_hz"], truth["side_modes_visible"]) == ("single_axis", [], False)
    assert truth["main_mode_hz"] == truth["f_nat_hz"]
    assert truth["z_residual_am2_per_s"] is None


def test_main_modes_of_both_models_start_alike():
    one, five = (still(name, 215e-6)[0].truth() for name in ("thread", "thread_imperfect"))
    assert five["amplitude_tx_end_deg"] == pytest.approx(one["amplitude_tx_end_deg"], rel=0.02)


def test_what_is_left_of_side_modes_goes_into_the_next_shot_until_it_has_died():
    bench, _ = still("thread_imperfect", 280e-6)
    bench.clock.sleep(0.05)
    bench.shot(0.0, rx=RX)
    soon = bench.backend.world.shot_simulator.result()
    assert np.abs(true_dm_dt(*soon)).max() > 1.0
    bench.backend.world.hold_still()
    bench.shot(0.0, rx=RX)
    assert np.abs(true_dm_dt(*bench.backend.world.shot_simulator.result())).max() < 1e-9


def test_a_shot_that_is_cut_short_is_known_up_to_its_end():
    bench = Bench("jewel_imperfect", **QUIET)
    bench.start(bench.line_up(490e-6, rx=RX))
    bench.clock.sleep(0.1)
    bench.backend.world.stop()
    setup, result = bench.backend.world.shot_simulator.result()
    known = true_dm_dt(setup, result).shape[1]
    assert 0 < known < RX
    assert record(setup, result, 22.0, [])["rotor_model"] == "rigid_body"
    assert abs(known / CLOCK.rate_hz - (0.1 - setup.rx_start_s())) < 1e-3


def test_an_open_ended_shot_goes_on_from_leg_to_leg():
    bench, _ = still("jewel_imperfect", 490e-6)
    setup, whole = bench.backend.world.shot_simulator.result()
    first = replace(setup, stop_s=0.1, open_ended=True)
    before = simulate(first)
    following = next_leg(first, before, bench.line_up(0.0, rx=RX), ())
    result = simulate(replace(following, stop_s=setup.stop_s - 0.1))
    assert result.phi_rad == pytest.approx(whole.phi_rad, abs=1e-6)
    assert np.all(np.isfinite(result.received.volts))


def orientations(seed, shots=30):
    bench = Bench("jewel_imperfect", **QUIET, seed=seed)
    out = []
    for _ in range(shots):
        bench.backend.world.hold_still()
        bench.shot(0.0, rx=16)
        truth = bench.truth()
        out.append([truth[f"rodrigues_{axis}"] for axis in "xyz"])
    return np.array(out)


@pytest.mark.long
def test_the_jewels_orientation_wobbles_from_shot_to_shot_as_in_the_paper():
    first = orientations(7)
    assert np.array_equal(first, orientations(7))
    assert not np.array_equal(first, orientations(8))
    turns = [rotation_matrix(a).T @ rotation_matrix(b) for a, b in pairwise(first)]
    angles_deg = [np.degrees(np.arccos((np.trace(t) - 1) / 2)) for t in turns]
    assert 0.08 < np.mean(angles_deg) < 0.13  # tab:model_params_fit_result


def test_undeclared_torques_are_refused_on_a_rigid_body_and_signals_are_not():
    tone = {"id": "spectral_line", "strength": 0.1, "frequency_hz": 1000.0}
    assert Bench("thread_imperfect", undeclared=[tone]).shot(215e-6, rx=610).size
    drag = {"id": "quadratic_drag", "strength": 1e-3}
    with pytest.raises(ConfigError, match=r"quadratic_drag.*single_axis"):
        Bench("thread_imperfect", undeclared=[drag])


def test_back_action_of_the_coils_brakes_the_rigid_body_as_the_single_axis_rotor():
    on = {"effects__back_action__enabled": True, "effects__back_action__scale": 200.0}
    drop = []
    for name in ("thread", "thread_imperfect"):
        amplitudes = [still(name, 100e-6, **more)[0].truth()["amplitude_tx_end_rad"] for more in ({}, on)]
        drop.append(amplitudes[1] / amplitudes[0])
    assert drop[0] < 0.99
    assert drop[1] == pytest.approx(drop[0], rel=1e-3)


def test_a_world_without_a_rigid_body_does_not_even_import_its_kernels():
    done = subprocess.run([sys.executable, "-c", LAZY], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["single_axis", "0"]


def test_every_shipped_specimen_says_which_model_moves_it():
    for name, model in (
        ("thread", "single_axis"),
        ("jewel", "single_axis"),
        ("thread_imperfect", "rigid_body"),
        ("jewel_imperfect", "rigid_body"),
    ):
        found = specimen(name)
        assert "rotor" in found.model_fields_set
        assert found.rotor.model == model
