from platform_daemon.core.recordings.units import unit_of
from platform_daemon.estimation.physics.models import MODELS, model_named
from platform_daemon.estimation.physics.torques import TERMS


def test_the_unit_in_the_name_of_every_parameter_is_the_one_that_the_estimation_declares() -> None:
    declared = {c.name: c.unit for term in TERMS.values() for c in term.coefficients}
    declared |= {p.name: p.unit for name in MODELS for p in model_named(name).parameters.values()}
    assert {"f_nat_hz", "m_r_am2", "rodrigues_x", "lambda_per_s", "anharmonicity"} <= set(declared)
    assert {name: unit_of(name) for name in declared} == declared


def test_names_of_the_simulated_truth() -> None:
    named = {"a.b_0_t": "T", "a.inertia_kg_m2": "kg m^2", "a.rodrigues_z": "rad", "a.seed": "1", "contact_lost": "1"}
    assert {name: unit_of(name) for name in named} == named


def test_powers_of_seconds_and_radians_that_a_coefficient_of_a_term_may_have() -> None:
    named = {"relaxation_s": "s", "jerk_s2": "s^2", "loss_per_s3": "1/s^3", "bend_per_rad2": "1/rad^2"}
    assert {name: unit_of(name) for name in named} == named
