"""Regression with errors in both variables: against other programs, against the truth, and what is refused."""

import math
import warnings

import numpy as np
import pytest

from drivers.errors import InputError
from platform_daemon.uncertainty.calibration_curve import (
    Points,
    fit_curve,
    trend_in,
    turning_points,
    with_lag,
)
from platform_daemon.uncertainty.cross_validation import cross_validated
from platform_daemon.uncertainty.curves import Dipole, Polynomial


def _points(curve, p, n=60, u_x=0.05, u_f=0.02, seed=0, low=1.0, high=5.0):
    random = np.random.default_rng(seed)
    true = np.linspace(low, high, n)
    f = curve.value(np.array(p), true) + u_f * random.standard_normal(n)
    return Points(true + u_x * random.standard_normal(n), np.full(n, u_x), f, np.full(n, u_f)), true


def test_a_polynomial_is_that_of_orthogonal_distance_regression():
    curve = Polynomial(2, 3.0, 2.0)
    points, _ = _points(curve, [213.0, -0.8, 0.1])
    found = fit_curve(curve, points)
    u_f = np.full(len(points.x), found.scatter)  # what the regression has found, so that both weigh alike
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        from scipy import odr

        data = odr.RealData(points.x, points.f, sx=points.u_x, sy=u_f)
        theirs = odr.ODR(data, odr.Model(curve.value), beta0=[213.0, -1.0, 0.0]).run()
    assert found.parameters == pytest.approx(theirs.beta, abs=1e-5)
    assert np.sqrt(found.covariance.diagonal()) == pytest.approx(np.sqrt(theirs.cov_beta.diagonal()), rel=0.02)


def test_a_straight_line_is_that_of_york():
    """Pearson's data with York's weights: the line of York (Can. J. Phys. 44 (1966) 1079) and of later papers."""
    x = np.array([0.0, 0.9, 1.8, 2.6, 3.3, 4.4, 5.2, 6.1, 6.5, 7.4])
    y = np.array([5.9, 5.4, 4.4, 4.6, 3.5, 3.7, 2.8, 2.8, 2.4, 1.5])
    w_x = np.array([1000.0, 1000.0, 500.0, 800.0, 200.0, 80.0, 60.0, 20.0, 1.8, 1.0])
    w_y = np.array([1.0, 1.8, 4.0, 8.0, 20.0, 20.0, 70.0, 70.0, 100.0, 500.0])
    found = fit_curve(Polynomial(1, 0.0, 1.0), Points(x, w_x**-0.5, y, w_y**-0.5))
    # With the weights alone it is 5.47991 - 0.480533 x; the scatter that is found here besides is small.
    assert found.parameters == pytest.approx([5.47991, -0.480533], rel=0.01)


@pytest.mark.parametrize(
    ("curve", "p"), [(Polynomial(1, 3.0, 2.0), [213.0, -0.8]), (Dipole(), [2000.0, 0.3])], ids=["line", "dipole"]
)
def test_readings_are_covered(curve, p):
    within, parameters = [], []
    for seed in range(60):
        points, _ = _points(curve, p, seed=seed)
        found = fit_curve(curve, points)
        parameters.append(np.abs(found.parameters - p) / np.sqrt(found.covariance.diagonal()))
        random = np.random.default_rng(1000 + seed)
        for x in random.uniform(1.4, 4.6, 5):
            f = float(curve.value(np.array(p), np.array([x]))[0]) + 0.02 * random.standard_normal()
            low, high = found.read("x", f).interval
            within.append(low <= x <= high)
    assert 0.9 <= np.mean(within) <= 0.99
    assert 0.85 <= np.mean(np.array(parameters) < 1.96) <= 1.0


def test_a_point_that_is_known_badly_does_not_hide_the_scatter_of_the_others():
    """One reading of the reference has u = 2, the others 0.01: f scatters by 0.05 nevertheless, and U says so."""
    curve, hits, scatters = Polynomial(1, 3.0, 2.0), [], []
    for seed in range(40):
        random = np.random.default_rng(seed)
        x, u_x = np.linspace(1.0, 5.0, 30), np.full(30, 0.01)
        u_x[7] = 2.0
        f = curve.value(np.array([213.0, -0.8]), x) + 0.05 * random.standard_normal(30)
        found = fit_curve(curve, Points(x + u_x * random.standard_normal(30), u_x, f, np.full(30, 1e-3)))
        scatters.append(found.scatter)
        low, high = found.read("x", 213.0 - 0.4 + 0.05 * random.standard_normal()).interval
        hits.append(low <= 4.0 <= high)
    assert np.mean(scatters) == pytest.approx(0.05, rel=0.1)
    assert np.mean(hits) >= 0.85


def test_a_second_influence_is_taken_out():
    curve, random = Polynomial(1, 3.0, 2.0), np.random.default_rng(2)
    points, true = _points(curve, [213.0, -0.8], u_x=0.001)
    celsius = 22.0 + random.standard_normal(len(true))
    warm = Points(points.x, points.u_x, points.f - 0.23 * (celsius - 22.0), points.u_f, celsius)
    found = fit_curve(curve, warm)
    assert found.parameters[-1] == pytest.approx(-0.23, abs=0.01)
    f = float(curve.value(np.array([213.0, -0.8]), np.array([2.5]))[0]) - 0.23 * 2.0
    assert found.read("x", f, 24.0).value == pytest.approx(2.5, abs=0.05)
    assert found.read("x", f, 24.0, u_second=0.1).u > found.read("x", f, 24.0).u


def test_a_lag_is_found():
    curve, random = Polynomial(1, 3.0, 2.0), np.random.default_rng(3)
    t = np.arange(0.0, 3000.0, 15.0)
    f = curve.value(np.array([213.0, -0.8]), 3.0 + 1.5 * np.sin((t - 40.0) / 200.0)) + 0.01 * random.standard_normal(
        len(t)
    )
    noise = 0.01 * random.standard_normal(len(t))

    def points_at(lag):
        return Points(3.0 + 1.5 * np.sin((t - lag) / 200.0) + noise, np.full(len(t), 0.01), f, np.full(len(t), 0.01))

    found, _, lag, u_lag = with_lag(curve, points_at, 200.0)
    assert lag == pytest.approx(40.0, abs=4.0 * u_lag)
    assert u_lag < 1.0
    assert found.parameters == pytest.approx([213.0, -0.8], abs=0.01)
    with pytest.raises(InputError, match="check the time zone"):
        with_lag(curve, points_at, 20.0)


def test_hysteresis_and_drift_are_seen_where_they_are():
    curve, t = Polynomial(1, 3.0, 2.0), np.linspace(0.0, 1.0, 200)
    random = np.random.default_rng(4)
    x = 3.0 + 1.5 * np.sin(20.0 * t)
    rising = np.sign(np.gradient(x))
    clean = curve.value(np.array([213.0, -0.8]), x) + 0.01 * random.standard_normal(len(t))
    for size in (0.0, 0.01):
        points = Points(x, np.full(len(x), 1e-4), clean + size * rising, np.full(len(x), 0.01))
        told = trend_in(fit_curve(curve, points), points, rising)
        assert (told.probability < 1e-3) == (size > 0.0)
        drifting = Points(x, np.full(len(x), 1e-4), clean + 3.0 * size * t, np.full(len(x), 0.01))
        told = trend_in(fit_curve(curve, drifting), drifting, t - t.mean())
        assert (told.probability < 1e-3) == (size > 0.0)
        assert told.value == pytest.approx(3.0 * size, abs=4.0 * told.u)


def test_cross_validation_tells_a_model_that_is_too_stiff():
    curve = Polynomial(2, 3.0, 2.0)
    points, _ = _points(curve, [213.0, -0.8, 0.25], u_x=0.005, u_f=0.005, n=100)
    right, stiff = cross_validated(curve, points), cross_validated(Polynomial(1, 3.0, 2.0), points)
    assert right.covered > 0.85
    assert stiff.rms > 5.0 * right.rms


def test_what_turns_is_told_where():
    curve = Polynomial(2, 3.0, 2.0)
    points, _ = _points(curve, [213.0, 0.0, 0.5], u_x=0.001)
    (at,) = turning_points(fit_curve(curve, points))
    assert at == pytest.approx(3.0, abs=0.1)


@pytest.mark.parametrize(
    ("n", "constant", "said"), [(4, False, "4 pairs for 3 parameters"), (20, True, "one value only")]
)
def test_pairs_that_do_not_suffice(n, constant, said):
    x = np.ones(n) if constant else np.linspace(1.0, 2.0, n)
    with pytest.raises(InputError, match=said):
        fit_curve(Polynomial(2, 1.5, 0.5), Points(x, np.full(n, 0.1), 213.0 + x, np.full(n, 0.1)))


@pytest.mark.parametrize(
    ("x", "said"),
    [
        (np.array([1.0, 1.5, 2.0, 2.5]), r"leaves out 1 of 4 pairs in turn, cannot be made.*3 pairs for 2 parameters"),
        (np.array([1.0] * 8 + [2.0, 2.0]), r"leaves out 2 of 10 pairs.*the reference has one value only then"),
    ],
)
def test_pairs_that_do_not_suffice_for_a_cross_validation(x, said):
    n = len(x)
    f = 213.0 + x + 1e-3 * np.random.default_rng(1).standard_normal(n)
    points = Points(x, np.full(n, 0.01), f, np.full(n, 0.01))
    fit_curve(Polynomial(1, 1.5, 0.5), points)
    with pytest.raises(InputError, match=said):
        cross_validated(Polynomial(1, 1.5, 0.5), points)


def test_a_reading_outside_is_refused_unless_asked_for():
    curve = Polynomial(1, 3.0, 2.0)
    found = fit_curve(curve, _points(curve, [213.0, -0.8])[0])
    f = float(curve.value(np.array([213.0, -0.8]), np.array([7.0]))[0])
    with pytest.raises(InputError, match="calibrate over a wider range"):
        found.read("x", f)
    told = found.read("x", f, within=(0.0, 10.0))
    assert told.value == pytest.approx(7.0, abs=0.3)
    assert told.u > found.read("x", 213.0).u
    assert math.isfinite(told.expanded)
