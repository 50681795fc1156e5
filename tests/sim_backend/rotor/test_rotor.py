import numpy as np
import pytest

from drivers.errors import ConfigError
from drivers.specimen import Measured
from sim_backend.rotor.rotor import axial_force_n, design, effective, rotation_matrix
from sim_backend.rotor.torque import MOMENT, STIFFNESS, parameters
from tests.kit.simulated_bench import specimen


def changed(name, **tables):
    raw = specimen(name).model_dump()
    for table, values in tables.items():
        raw[table] = values if values is None else raw[table] | values
    return type(specimen(name)).model_validate(raw)


def test_design_values_are_those_of_the_paper():
    plan = design(specimen("jewel"))
    assert plan.m_r_am2 == pytest.approx(14.625e-3, rel=1e-4)
    assert plan.m_stator_am2 == plan.m_r_am2
    assert plan.f_nat_hz == pytest.approx(229.31, abs=0.005)
    assert plan.axial_force_n == pytest.approx(131.50e-3, rel=1e-4)
    assert plan.inertia_kg_m2 == pytest.approx(9.924e-11, rel=1e-4)
    assert plan.b_0_t == pytest.approx(14.09e-3, rel=1e-3)


def test_natural_frequency_follows_the_papers_closed_formula():
    from scipy.constants import mu_0

    m = specimen("thread").magnets
    closed = np.sqrt(5 * m.remanence_t**2 * m.radius_m / (6 * m.density_kg_per_m3 * m.distance_m**3 * mu_0))
    assert design(specimen("thread")).f_nat_hz == pytest.approx(closed / (2 * np.pi), rel=1e-12)


def test_printed_friction_follows_from_mu_012_and_not_from_015():
    assert design(specimen("jewel")).tf_over_i_rad_per_s2 == pytest.approx(1460, abs=1)
    smooth = changed("jewel", jewel={"friction_coefficient": 0.12})
    assert design(smooth).tf_over_i_rad_per_s2 == pytest.approx(1168, abs=1)
    assert design(smooth).tf_nm == pytest.approx(115.9e-9, rel=1e-3)


@pytest.mark.parametrize(("ratio", "expected"), [(5 / 3, 1.3572), (2.0, 1.2599), (4.0, 1.1006)])
def test_friction_depends_on_the_cup_as_the_auxiliary_function(ratio, expected):
    wide = design(changed("jewel", jewel={"cup_radius_m": 1e6})).tf_nm
    assert design(changed("jewel", jewel={"cup_radius_m": ratio * 1.5e-3})).tf_nm / wide == pytest.approx(
        expected, abs=1e-4
    )


def test_measured_values_override_design_values_and_keep_the_inertia():
    rotor, plan = effective(specimen("thread")), design(specimen("thread"))
    assert (rotor.f_nat_hz, rotor.m_r_am2, rotor.lambda_per_s) == (215.69, 11.014e-3, 0.2465)
    assert rotor.inertia_kg_m2 == plan.inertia_kg_m2
    assert rotor.m_r_am2 * rotor.b_0_t / rotor.inertia_kg_m2 == pytest.approx(rotor.omega_rad_per_s**2, rel=1e-14)
    q = parameters(rotor)
    assert q[MOMENT] == rotor.m_r_am2 / plan.inertia_kg_m2
    assert q[STIFFNESS] == rotor.omega_rad_per_s**2


def test_without_measured_values_the_design_holds():
    """lambda has no design equation: that of the paper's jewel."""
    bare = specimen("jewel").model_copy(update={"measured": Measured()})
    rotor, plan = effective(bare), design(bare)
    assert (rotor.f_nat_hz, rotor.m_r_am2) == (plan.f_nat_hz, plan.m_r_am2)
    assert (rotor.tf_over_i_rad_per_s2, rotor.lambda_per_s) == (plan.tf_over_i_rad_per_s2, 0.0978)
    assert rotor.b_0_t == pytest.approx(plan.b_0_t, rel=1e-12)


def test_force_falls_with_the_fourth_power_of_distance():
    near, far = specimen("jewel").magnets, changed("jewel", magnets={"distance_m": 9.4e-3}).magnets
    assert axial_force_n(near) / axial_force_n(far) == pytest.approx(16, rel=1e-12)


def test_a_cup_narrower_than_the_sphere_is_refused():
    with pytest.raises(ConfigError, match="not wider than the sphere"):
        effective(changed("jewel", jewel={"cup_radius_m": 1.5e-3}))


def test_shipped_pose_turns_v_to_x_and_keeps_w_on_z():
    rotation = effective(specimen("thread")).rotation
    assert rotation @ [0, 1, 0] == pytest.approx([1, 0, 0], abs=1e-15)
    assert rotation @ [0, 0, 1] == pytest.approx([0, 0, 1], abs=1e-15)


def test_rotation_is_proper_for_any_vector():
    for vector in np.random.default_rng(1).normal(size=(20, 3)):
        rotation = rotation_matrix(vector)
        assert rotation @ rotation.T == pytest.approx(np.eye(3), abs=1e-14)
        assert np.linalg.det(rotation) == pytest.approx(1)
        assert rotation @ vector == pytest.approx(vector, abs=1e-14)
    assert np.array_equal(rotation_matrix(np.zeros(3)), np.eye(3))
