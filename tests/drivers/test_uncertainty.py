"""What platform and resonator files may declare, and what they may not."""

import math

import pytest
from pydantic import ValidationError

from drivers.uncertainty import DeclaredUncertainty


def _declared(**keys):
    return DeclaredUncertainty.model_validate(keys)


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ({}, "either u or half_width"),
        ({"u": 1e-6, "half_width": 1e-6}, "either u or half_width"),
        ({"u": 0.0}, "greater than 0"),
        ({"u": -1e-6}, "greater than 0"),
        ({"half_width": 1e-6}, "a normal distribution has no half_width"),
        ({"u": 1e-6, "dof": 0.0}, "greater than or equal to 1"),
        ({"u": 1e-6, "certificate": {"number": "1", "date": "2026-02-01", "valid_until": "2026-01-01"}}, "before date"),
    ],
)
def test_an_influence_that_is_none(value, said):
    with pytest.raises(ValidationError, match=said):
        _declared(sample_clock=value)


def test_a_half_width_is_that_of_its_distribution():
    told = _declared(sample_clock={"half_width": 3.0, "distribution": "triangular"}).sample_clock
    assert told is not None
    assert told.standard_uncertainty == pytest.approx(3.0 / math.sqrt(6.0))


def test_a_resonator_speaks_for_itself():
    platform = _declared(position_m={"u": 1e-3}, temperature_coefficient_per_k={"f_nat_hz": -0.2})
    own = _declared(position_m={"u": 2e-3}, temperature_coefficient_per_k={"m_r_am2": -1e-5})
    both = platform.under(own)
    assert both.position_m == own.position_m
    assert both.temperature_coefficient_per_k == {"f_nat_hz": -0.2, "m_r_am2": -1e-5}
    assert platform.under(None) is platform


def test_correlations_of_a_resonator_replace_those_of_the_platform():
    def between(one, other, r):
        return {"between": [one, other], "r": r}

    platform = _declared(correlation=[between("a", "b", 0.5), between("a", "c", 0.1)])
    both = platform.under(_declared(correlation=[between("b", "a", 0.2)]))
    assert [(each.between, each.r) for each in both.correlation] == [(("a", "c"), 0.1), (("b", "a"), 0.2)]
    with pytest.raises(ValidationError, match=r"'b' and 'a' is declared twice, as 0\.5 and 0\.4"):
        _declared(correlation=[between("a", "b", 0.5), between("b", "a", 0.4)])
    with pytest.raises(ValidationError, match="'a' with itself"):
        _declared(correlation=[between("a", "a", 1.0)])
    for r in (1.5, -1.01, math.nan, "0.5"):
        with pytest.raises(ValidationError, match=r"correlation\.0\.r"):
            _declared(correlation=[between("a", "b", r)])
