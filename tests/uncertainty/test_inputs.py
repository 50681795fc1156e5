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
        ({"u": "0.1"}, "'0.1' is no number"),
        ({"value": None}, "None is no number"),
        ({"kind": "C"}, r"no type 'C' of evaluation.*A: evaluated from repeated"),
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
        ({("one", "two"): 0.0, ("two", "one"): 0.4}, "0 and 0.4 are both given"),
        ({("one", "two"): math.nan}, "between -1 and 1"),
        ([[1.0, 0.5], [0.4, 1.0]], r"two and one: 0\.5 and 0\.4 are both given"),
        ([[1.0, math.nan], [math.nan, 1.0]], "the coefficient is nan"),
        ([[1.0, 1.2], [1.2, 1.0]], "the coefficient is 1.2"),
        ([[4.0, 0.5], [0.5, 1.0]], r"the diagonal holds 4 for one, not 1.*a covariance over both"),
        (np.eye(3), r"a matrix of the shape \(3, 3\) for 2 inputs.*one of 2 by 2"),
        (np.ones(2), r"a matrix of the shape \(2,\)"),
        ([["a", "b"], ["c", "d"]], "not all are numbers"),
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

    matrix = np.array([[1.0, 0.9, -0.9], [0.9, 1.0, 0.9], [-0.9, 0.9, 1.0]])
    with pytest.raises(pd_.InputError, match=r"one, three, two: .* contradict each other.*eigenvalue -0\.8"):
        pd_.monte_carlo(lambda a, b, c: a + b + c, (ONE, TWO, three), matrix)


def test_a_matrix_is_the_same_as_its_coefficients():
    matrix = np.array([[1.0, -0.3], [-0.3, 1.0]])
    by_matrix, by_name = (
        pd_.propagate(_add, (ONE, TWO), matrix),
        pd_.propagate(_add, (ONE, TWO), {("one", "two"): -0.3}),
    )
    assert (by_matrix.u, by_matrix.correlations) == (by_name.u, (("one", "two", -0.3),))
    assert by_matrix.u == pytest.approx(math.sqrt(0.01 + 0.04 - 0.3 * 2 * 0.1 * 0.2))
    flat = pd_.InputQuantity.within("flat", 0.0, 1.0)
    assert pd_.propagate(_add, (ONE, flat), np.eye(2), second_order=True).u > 0.1
    with pytest.raises(pd_.InputError, match="hold for independent inputs"):
        pd_.propagate(_add, (ONE, TWO), matrix, second_order=True)


@pytest.mark.parametrize(
    ("observed", "said"),
    [
        ({}, "there are no observations"),
        ({"a": [1.0, 2.0], "b": [1.0]}, r"b: observations of the shape \(1,\)"),
        ({"a": [1.0]}, "at least two"),
        ({"a": ["1,5", "2,5"]}, "a: not all are numbers"),
        ({"a": [1.0, math.nan]}, "a: an observation is no finite number"),
        ({"a": [2.0, 2.0]}, "a: the standard uncertainty is 0"),
    ],
)
def test_observations_that_are_none(observed, said):
    with pytest.raises(pd_.InputError, match=said):
        pd_.from_observations(observed)


def test_a_model_without_inputs():
    with pytest.raises(pd_.InputError, match="the model has no inputs"):
        pd_.propagate(lambda: 1.0, ())


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
