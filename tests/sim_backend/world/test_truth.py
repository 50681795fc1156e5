import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim_backend.rotor.rotor import rotation_matrix
from sim_backend.world.truth import label, pose
from tests.kit.simulated_bench import Bench

OMEGA = 1340.0


@given(st.floats(1e-6, 1.5), st.floats(0, 2 * np.pi - 1e-9))
def test_label_inverts_the_papers_definition_of_the_start_state(phi_max, psi):
    phi = phi_max * np.cos(psi)
    phi_dot = -OMEGA * 2 * np.sin(phi_max / 2) * np.sin(psi)  # sqrt(2 - 2 cos) without its rounding
    found = label(phi, phi_dot, OMEGA)
    assert found is not None
    assert found[0] == pytest.approx(phi_max, rel=1e-7)
    assert np.exp(1j * found[1]) == pytest.approx(np.exp(1j * psi), abs=1e-7)
    assert 0 <= found[1] < 2 * np.pi


def test_label_of_the_state_of_rest_is_zero_and_of_an_overturning_rotor_none():
    assert label(0.0, 0.0, OMEGA) == (0.0, 0.0)
    assert label(0.0, 2.5 * OMEGA, OMEGA) is None
    assert label(4.0, 0.0, OMEGA) is None


def test_pose_follows_the_convention_and_gives_the_same_signal():
    for vector in np.random.default_rng(2).normal(size=(30, 3)):
        rotation = rotation_matrix(vector)
        found, sign = pose(rotation)
        turned = rotation_matrix(found)
        assert turned[0, 1] > 0
        assert np.linalg.norm(found) <= np.pi
        phi, phi_dot = 0.3, 200.0
        before = rotation[:, :2] @ [-phi_dot * np.sin(phi), phi_dot * np.cos(phi)]
        following = turned[:, :2] @ [-sign * phi_dot * np.sin(sign * phi), sign * phi_dot * np.cos(sign * phi)]
        assert following == pytest.approx(before, abs=1e-10)


def test_truth_is_plain_json_and_complete():
    bench = Bench("jewel")
    assert bench.backend.ground_truth() is None
    bench.shot(rx=610)
    truth = bench.truth()
    assert json.loads(json.dumps(truth, allow_nan=False)) == truth
    wanted = "seed shot variant effects f_nat_hz m_r_am2 lambda_per_s tf_over_i_rad_per_s2 phi_max_rad psi_start_rad "
    wanted += "rodrigues_x rodrigues_y rodrigues_z phi_rad phi_dot_rad_per_s amplitude_tx_end_deg amplitude_tx_end_rad "
    wanted += "noise_sd_am2_per_s temperature_c contact_lost amplitude_end_rad violations"
    assert set(wanted.split()) <= set(truth)
    assert label(truth["phi_rad"], truth["phi_dot_rad_per_s"], 2 * np.pi * truth["f_nat_hz"]) == pytest.approx(
        (truth["phi_max_rad"], truth["psi_start_rad"])
    )
