"""The one table of parameters is that of the estimation."""

from __future__ import annotations

import math

from platform_daemon.core.schemas.parameters import PARAMETERS, RODRIGUES, definition_of, names_in_order
from platform_daemon.estimation.parameters import PARAMETER_NAMES
from platform_daemon.estimation.physics.models import MODELS
from platform_daemon.estimation.physics.torques import IN_PLACE, TERMS

LAWS = (*TERMS.values(), *IN_PLACE)


def test_it_holds_every_parameter_of_every_model_in_the_order_of_the_fit() -> None:
    further = dict.fromkeys(c.name for term in LAWS for c in term.coefficients if c.name not in PARAMETER_NAMES)
    assert list(PARAMETERS) == [*PARAMETER_NAMES, *further]


def test_units_are_those_of_the_models() -> None:
    declared = {p.name: p.unit for model in MODELS.values() for p in model.parameters.values()}
    declared |= {c.name: c.unit for term in LAWS for c in term.coefficients}
    assert {name: PARAMETERS[name].unit for name in declared} == declared
    assert set(declared) == set(PARAMETERS)


def test_headings_and_factors() -> None:
    shown = {name: (p.heading, p.display_factor) for name, p in PARAMETERS.items()}
    assert shown["m_r_am2"] == ("m_r / mAm²", 1e3)
    assert shown["tf_over_i_rad_per_s2"] == ("T_f/I / rad s⁻²", 1.0)
    assert shown["phi_max_rad"] == ("φ_max / °", math.degrees(1))
    assert shown["anharmonicity"] == ("β", 1.0)
    assert PARAMETERS["f_nat_hz"].axis_label == "$f_{nat}$ / Hz"


def test_a_parameter_of_another_program_is_shown_by_its_name() -> None:
    assert definition_of("viscosity_pa_s").heading == "viscosity_pa_s"
    assert definition_of("lambda_per_s").heading == "λ / s⁻¹"


def test_order() -> None:
    assert names_in_order({"rodrigues_z", "lambda_per_s", "f_nat_hz"}) == ["f_nat_hz", "lambda_per_s", "rodrigues_z"]
    assert names_in_order(set(RODRIGUES)) == list(RODRIGUES)
