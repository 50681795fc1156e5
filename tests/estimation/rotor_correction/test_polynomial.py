"""Polynomials in a box: what they reproduce, and their derivatives."""

import numpy as np
import pytest

from platform_daemon.estimation.rotor_correction.polynomial import Box, Polynomial


def test_a_polynomial_of_the_kinds_it_holds_is_reproduced_with_its_slope():
    rng = np.random.default_rng(1)
    places = rng.uniform([-1.0, 10.0, 0.0], [1.0, 12.0, 3.0], (200, 3))

    def value(x, y, z):
        return np.array([2.0 + x * y - z**5, z**3 * (y - 11.0)])

    fitted = Polynomial.fitted(Box.around(places, bent=2), places, np.array([value(*place) for place in places]))
    at = np.array([0.3, 11.2, 1.7])
    assert fitted.at(at) == pytest.approx(value(*at), abs=1e-5)
    slope = [[at[1], at[0], -5.0 * at[2] ** 4], [0.0, at[2] ** 3, 3.0 * at[2] ** 2 * (at[1] - 11.0)]]
    assert fitted.slope(at) == pytest.approx(np.array(slope), abs=1e-3)


def test_places_without_weight_do_not_count():
    places = np.linspace(-1.0, 1.0, 60)[:, None]
    weights = (places[:, 0] < 0.5).astype(float)
    values = np.where(weights > 0.0, 3.0 * places[:, 0], 1e3)
    fitted = Polynomial.fitted(Box.around(places, bent=0), places, values, weights)
    assert fitted.at(np.array([0.2])) == pytest.approx(0.6, abs=1e-3)
