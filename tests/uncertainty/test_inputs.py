"""What is refused, each with its remedy; degrees of freedom and draws where the examples do not look."""

import math

import numpy as np
import pytest

import platform_daemon as pd_

ONE, TWO = pd_.InputQuantity(name="one", value=1.0, u=0.1), pd_.InputQuantity(name="two", value=2.0, u=0.2)


def _add(a, b):
    return a + b


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"u": 0.0}, "the standard uncertainty is 0.0"),
        ({"u": -1.0}, "the standard uncertainty is -1.0"),
        ({"u": math.nan}, "the standard uncertainty is nan"),
        ({"value": math.inf}, "the value is inf"),
        ({"dof": 0.5}, "0.5 degrees of freedom"),
        ({"distribution": "lognormal"}, "one of: normal, rectangular, triangular, arcsine"),
    ],
)
def test_inputs_that_are_none(values, said):
    with pytest.raises(pd_.InputError, match=said):
        pd_.InputQuantity(**{"name": "x", "value": 1.0, "u": 1.0, **values})


@pytest.mark.parametrize(
    ("between", "said"),
    [
        ({("one", "three"): 0.5}, "no input 'three'"),
        ({("one", "two"): 1.5}, "between -1 and 1"),
        ({("one", "one"): 0.5}, "name two inputs"),
        ({("one", "two"): 0.5, ("two", "one"): 0.4}, "are both given"),
    ],
)
def test_correlations_that_are_none(between, said):
    with pytest.raises(pd_.InputError, match=said):
        pd_.propagate(_add, (ONE, TWO), between)


def test_a_matrix_that_is_none_names_its_inputs():
    three = pd_.InputQuantity(name="three", value=0.0, u=1.0)
    between = {("one", "two"): 0.9, ("two", "three"): 0.9, ("one", "three"): -0.9}
    with pytest.raises(pd_.InputError, match=r"one, three, two: .* contradict each other.*eigenvalue -0\.8"):
        pd_.propagate(lambda a, b, c: a + b + c, (ONE, TWO, three), between)


def test_a_correlated_input_must_be_normal_to_be_drawn():
    flat = pd_.InputQuantity.within("flat", 0.0, 1.0)
    with pytest.raises(pd_.InputError, match="a correlated input is not normal"):
        pd_.monte_carlo(_add, (ONE, flat), {("one", "flat"): 0.5})


@pytest.mark.parametrize("coverage", [0.0, 1.0, 95.0, math.nan])
def test_a_coverage_that_is_no_probability(coverage):
    with pytest.raises(pd_.InputError, match=r"as 0\.95"):
        pd_.propagate(_add, (ONE, TWO), coverage=coverage)


def test_a_cusp_has_no_derivative():
    with pytest.raises(pd_.InputError, match="no derivative at the estimates"):
        pd_.propagate(lambda a, b: np.cbrt(a - 1.0) + b, (ONE, TWO))


def test_a_model_that_takes_no_arrays():
    with pytest.raises(pd_.InputError, match="does not take arrays"):
        pd_.propagate(lambda a, b: math.sqrt(a) + b, (ONE, TWO))


def test_full_correlation_adds_up():
    assert pd_.propagate(_add, (ONE, TWO), {("one", "two"): 1.0}).u == pytest.approx(0.3)
    assert pd_.propagate(lambda a, b: b - a, (ONE, TWO), {("one", "two"): 1.0}).u == pytest.approx(0.1)


def test_few_degrees_of_freedom_are_drawn_as_t():
    few = pd_.InputQuantity(name="few", value=0.0, u=1.0, kind="A", dof=4)
    budget = pd_.propagate(lambda x: x, (few,))
    drawn = pd_.monte_carlo(lambda x: x, (few,), trials=200_000)
    assert budget.k == pytest.approx(2.776, abs=1e-3)
    assert drawn.high == pytest.approx(budget.expanded, rel=0.02)
    assert drawn.u == pytest.approx(math.sqrt(2.0), rel=0.05)  # of t with four


def test_same_seed_same_draws():
    one, other = (pd_.monte_carlo(_add, (ONE, TWO), trials=2_000, seed=7) for _ in range(2))
    assert np.array_equal(one.draws, other.draws)
