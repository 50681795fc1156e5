"""Examples of the GUM and of its supplement 1 by the library's public face, to their printed digits; GTC agrees.

Inputs and printed digits of H.1 and H.2 (JCGM 100:2008, annex H) were compared with two other programs that quote them:
GTC (github.com/MSLNZ/GTC, docs/API/GUM_H1.rst, test/test_type_a.py: test_GUM_H2_wo_labels) and suncal
(github.com/sandialabs/suncal, test/test_examples.py: test_GUMH2, test/test_GUMH2.csv).  Those of 9.2 to 9.4 (JCGM
101:2008) that are moments or ends of closed distributions are computed here once more from their equations.  The
digits of H.3 and 9.5 are quoted without a second program.
"""

import math

import GTC
import numpy as np
import pytest

import platform_daemon as pd_

NORMAL, WITHIN = pd_.InputQuantity, pd_.InputQuantity.within


# H.1: an end gauge, nm.
H1 = (
    NORMAL(name="l_S", value=50_000_623.0, u=25.0, dof=18),
    NORMAL(name="d", value=215.0, u=5.8, kind="A", dof=24),
    NORMAL(name="d_1", value=0.0, u=3.9, dof=5),
    NORMAL(name="d_2", value=0.0, u=6.7, dof=8),
    WITHIN("alpha_S", 11.5e-6, 2e-6),
    NORMAL(name="theta", value=-0.1, u=0.2),
    WITHIN("Delta", 0.0, 0.5, "arcsine"),
    WITHIN("delta alpha", 0.0, 1e-6, dof=50),
    WITHIN("delta theta", 0.0, 0.05, dof=2),
)


def _end_gauge(l_s, d, d_1, d_2, alpha, theta, cycle, d_alpha, d_theta):
    return l_s + d + d_1 + d_2 - l_s * (d_alpha * (theta + cycle) + alpha * d_theta)


def test_end_gauge():
    budget = pd_.propagate(_end_gauge, H1, coverage=0.99, quantity="l")
    lines = {line.input.name: line.contribution for line in budget.contributions}
    assert budget.value == pytest.approx(50_000_838.0)
    assert round(lines["delta alpha"], 1) == 2.9
    assert round(lines["delta theta"], 1) == 16.6
    assert round(math.hypot(lines["d"], lines["d_1"], lines["d_2"]), 1) == 9.7
    assert lines["alpha_S"] == pytest.approx(0.0, abs=1e-3)
    assert math.floor(budget.u**2) == 1002
    assert round(budget.u) == 32
    assert math.floor(budget.dof) == 16
    assert round(budget.k, 2) == 2.92
    assert round(budget.k * round(budget.u)) == 93  # the guide rounds u before it multiplies


def test_end_gauge_second_order():
    budget = pd_.propagate(_end_gauge, H1, second_order=True)
    assert round(budget.u) == 34
    assert math.sqrt(budget.higher_order) == pytest.approx(math.hypot(11.7, 1.7), abs=0.06)


def test_end_gauge_as_gtc():
    inputs = [GTC.ureal(each.value, each.u, each.dof) for each in H1]
    theirs, ours = _end_gauge(*inputs), pd_.propagate(_end_gauge, H1)
    assert ours.u == pytest.approx(theirs.u, rel=1e-7)  # of 5e7 nm, rounding leaves so much of a difference
    assert ours.dof == pytest.approx(theirs.df, rel=1e-6)


# H.2: resistance, reactance and impedance from five simultaneous observations.
H2 = {
    "V": (5.007, 4.994, 5.005, 4.990, 4.999),
    "I": (19.663e-3, 19.639e-3, 19.640e-3, 19.685e-3, 19.678e-3),
    "phi": (1.0456, 1.0438, 1.0468, 1.0428, 1.0433),
}


def _impedance(v, i, phi):
    return v / i * np.cos(phi), v / i * np.sin(phi), v / i


def test_resistance_and_reactance():
    inputs, between = pd_.from_observations(H2)
    assert [round(each.u, 5) for each in inputs] == [0.00321, 0.00001, 0.00075]
    assert [round(r, 2) for r in between.values()] == [-0.36, 0.86, -0.65]
    joint = pd_.propagate_jointly(_impedance, inputs, ("R", "X", "Z"), between)
    assert [round(each.value, 3) for each in joint.values()] == [127.732, 219.847, 254.260]
    assert round(joint["R"].u, 3) == 0.071
    assert joint["X"].u == pytest.approx(0.295, abs=0.0006)  # 0.2956: the guide has cut it
    assert round(joint["Z"].u, 3) == 0.236
    assert [each.dof for each in joint.values()] == pytest.approx([4.0] * 3)
    r = joint.correlation
    assert [round(float(each), 3) for each in (r[0, 1], r[0, 2], r[1, 2])] == [-0.588, -0.485, 0.993]


def test_resistance_and_reactance_as_gtc():
    theirs_in = GTC.ta.multi_estimate_real(list(H2.values()), labels=list(H2))
    z = theirs_in[0] / theirs_in[1]
    theirs = [z * GTC.cos(theirs_in[2]), z * GTC.sin(theirs_in[2]), z]
    inputs, between = pd_.from_observations(H2)
    ours = pd_.propagate_jointly(_impedance, inputs, ("R", "X", "Z"), between)
    assert [each.u for each in ours.values()] == pytest.approx([each.u for each in theirs], rel=1e-8)
    assert [each.dof for each in ours.values()] == pytest.approx([each.df for each in theirs], rel=1e-6)
    assert ours.correlation[0, 1] == pytest.approx(GTC.get_correlation(theirs[0], theirs[1]), rel=1e-7)


# Supplement 1, 9.2: a sum of four.
def _sum(a, b, c, d):
    return a + b + c + d


UNIT = math.sqrt(3.0)
ADDITIVE = {
    "9.2.2": ([NORMAL(name=n, value=0.0, u=1.0) for n in "abcd"], 2.00, 3.92, 3.92, True),
    "9.2.3": ([WITHIN(n, 0.0, UNIT) for n in "abcd"], 2.00, 3.92, 3.88, True),
    "9.2.4": ([*(WITHIN(n, 0.0, UNIT) for n in "abc"), WITHIN("d", 0.0, 10 * UNIT)], 10.1, 19.9, 17.0, False),
}


@pytest.mark.parametrize("clause", ADDITIVE)
def test_additive_model(clause):
    inputs, u, expanded, end, _ = ADDITIVE[clause]
    budget = pd_.propagate(_sum, inputs)
    drawn = pd_.monte_carlo(_sum, inputs, trials=500_000, seed=1, digits=2)
    digits = 2 if u < 10 else 1
    assert round(budget.u, digits) == u
    assert round(budget.expanded, digits) == expanded
    assert drawn.u == pytest.approx(u, abs=0.6 * 10**-digits)
    assert (-drawn.low, drawn.high) == pytest.approx((end, end), abs=3 * drawn.standard_error + 0.5 * 10**-digits)


def test_additive_model_where_the_law_fails():
    inputs = ADDITIVE["9.2.4"][0]
    drawn = pd_.monte_carlo(_sum, inputs, trials=200_000, digits=2)
    checked = pd_.check_law_of_propagation(pd_.propagate(_sum, inputs), drawn)
    assert drawn.tolerance == 0.5
    assert not checked.holds
    assert (checked.low_difference, checked.high_difference) == pytest.approx((2.8, 2.8), abs=0.15)


# 9.3: calibration of a weight, mg.
MASS = (
    NORMAL(name="m_Rc", value=100_000.000, u=0.050),
    NORMAL(name="dm_Rc", value=1.234, u=0.020),
    WITHIN("rho_a", 1.20, 0.10),
    WITHIN("rho_W", 8e3, 1e3),
    WITHIN("rho_R", 8e3, 50.0),
)


def _mass(m, dm, rho_a, rho_w, rho_r):
    return (m + dm) * (1.0 + (rho_a - 1.2) * (1.0 / rho_w - 1.0 / rho_r)) - 100_000.0


def test_mass_calibration():
    first, second = pd_.propagate(_mass, MASS), pd_.propagate(_mass, MASS, second_order=True)
    assert [round(x, 4) for x in (first.value, first.u, *first.interval)] == [1.2340, 0.0539, 1.1285, 1.3395]
    assert [round(x, 4) for x in (second.value, second.u)] == [1.2340, 0.0750]
    assert second.interval == pytest.approx((1.0870, 1.3810), abs=1.5e-4)
    drawn = pd_.monte_carlo(_mass, MASS, trials=400_000, seed=3)
    assert drawn.tolerance == 0.005
    assert (drawn.value, drawn.u) == pytest.approx((1.2341, 0.0754), abs=3e-4)
    assert drawn.shortest == pytest.approx((1.0834, 1.3825), abs=3e-3)
    assert not pd_.check_law_of_propagation(first, drawn).holds
    assert pd_.check_law_of_propagation(second, drawn).holds
    adaptive = pd_.monte_carlo(_mass, MASS)
    assert adaptive.stable
    assert adaptive.trials % 10_000 == 0


# 9.4: comparison loss of microwave power meters, in 1e-6: mean, u, and ends of the shortest interval.
LOSS = {
    (0.0, 0.000): (50, 50, 0, 150),
    (0.0, 0.010): (150, 112, 0, 367),
    (0.0, 0.050): (2551, 502, 1590, 3543),
    (0.9, 0.000): (50, 67, 0, 185),
    (0.9, 0.010): (150, 121, 13, 398),
    (0.9, 0.050): (2551, 505, 1628, 3555),
}
FIRST_ORDER = {0.0: 0, 0.010: 100, 0.050: 500}
SECOND_ORDER = {0.0: 50, 0.010: 112, 0.050: 502}


@pytest.mark.parametrize(("r", "x1"), LOSS)
def test_comparison_loss(r, x1):
    inputs = (NORMAL(name="x1", value=x1, u=0.005), NORMAL(name="x2", value=0.0, u=0.005))
    between = {("x1", "x2"): r} if r else None

    def loss(a, b):
        return a**2 + b**2

    drawn = pd_.monte_carlo(loss, inputs, between, trials=400_000, seed=5)
    mean, u, low, high = LOSS[r, x1]
    assert (1e6 * drawn.value, 1e6 * drawn.u) == pytest.approx((mean, u), abs=0.006 * u + 0.6)
    assert [1e6 * end for end in drawn.shortest] == pytest.approx([low, high], abs=0.04 * u + 0.6)
    assert round(1e6 * pd_.propagate(loss, inputs, between).u) == FIRST_ORDER[x1]
    if not r:
        assert round(1e6 * pd_.propagate(loss, inputs, second_order=True).u) == SECOND_ORDER[x1]


def test_digits_of_the_additive_models_follow_from_their_distributions():
    """9.2: the density of a sum of rectangular inputs is a spline, so that its quantiles are exact."""
    grid = np.linspace(-24.0, 24.0, 2**18, endpoint=False)
    step = grid[1] - grid[0]
    frequency = 2.0 * np.pi * np.fft.fftfreq(len(grid), step)

    def end(widths):
        spectrum = np.prod([np.sinc(width * frequency / np.pi) for width in widths], axis=0)
        density = np.fft.fftshift(np.fft.ifft(spectrum).real)
        return float(np.interp(0.975, np.cumsum(density) / density.sum(), grid))

    assert round(end([UNIT] * 4), 2) == ADDITIVE["9.2.3"][3]
    assert round(end([UNIT] * 3 + [10 * UNIT]), 1) == ADDITIVE["9.2.4"][3]


def test_digits_of_the_weight_follow_from_its_moments():
    """9.3.2: 1 / rho of a rectangular density has the moments ln(b / a) / (b - a) and 1 / (a b)."""
    air, variance = 0.1**2 / 3.0, 0.0
    means = []
    for low, high in ((7e3, 9e3), (8e3 - 50.0, 8e3 + 50.0)):
        means.append(math.log(high / low) / (high - low))
        variance += 1.0 / (low * high) - means[-1] ** 2
    buoyancy = air * (variance + (means[0] - means[1]) ** 2)  # (rho_a - 1.2) has the mean 0
    u = math.sqrt(0.050**2 + 0.020**2 + (1e5 + 1.234) ** 2 * buoyancy)
    assert u == pytest.approx(0.0754, abs=1.0e-4)  # printed of draws: the moments give 0.07548


@pytest.mark.parametrize(("r", "x1"), LOSS)
def test_digits_of_the_comparison_loss_follow_from_its_moments(r, x1):
    """9.4: mean x1^2 + 2 u^2 and variance 4 u^2 x1^2 + 4 u^4 (1 + r^2) of a sum of two squares of normal inputs."""
    u = 0.005
    mean, deviation = x1**2 + 2.0 * u**2, math.sqrt(4.0 * u**2 * x1**2 + 4.0 * u**4 * (1.0 + r**2))
    assert (round(1e6 * mean, 6), round(1e6 * deviation)) == pytest.approx((LOSS[r, x1][0], LOSS[r, x1][1]), abs=1)
    if x1 == 0.0 and not r:
        # The sum over u^2 is chi squared of two degrees of freedom, whose density falls from 0 on.
        assert round(1e6 * -2.0 * u**2 * math.log(0.05)) == LOSS[r, x1][3]


def test_a_thermometer():
    """H.3: the straight line by least squares, and the correction that it predicts at 30 degrees Celsius."""
    line = (
        NORMAL(name="y1", value=-0.1712, u=0.0029, kind="A", dof=9),
        NORMAL(name="y2", value=0.00218, u=0.00067, kind="A", dof=9),
    )
    found = pd_.propagate(lambda y1, y2: y1 + y2 * (30.0 - 20.0), line, [[1.0, -0.930], [-0.930, 1.0]])
    assert (round(found.value, 4), round(found.u, 4), round(found.dof)) == (-0.1494, 0.0041, 9)


GAUGE_BLOCK = (
    NORMAL(name="length of the standard / nm", value=50_000_623.0, u=25.0, dof=18),
    NORMAL(name="difference / nm", value=215.0, u=6.0, dof=24),
    NORMAL(name="random effects / nm", value=0.0, u=4.0, dof=5),
    NORMAL(name="systematic effects / nm", value=0.0, u=7.0, dof=8),
    NORMAL.within("expansion of the standard / K^-1", 11.5e-6, 2e-6),
    NORMAL(name="mean deviation of the temperature / K", value=-0.1, u=0.2),
    NORMAL.within("cyclic variation / K", 0.0, 0.5, "arcsine"),
    NORMAL.within("difference of the expansions / K^-1", 0.0, 1e-6, dof=50),
    NORMAL.within("difference of the temperatures / K", 0.0, 0.05, dof=2),
)


def test_gauge_block():
    """9.5 of the supplement; the ends of the last two inputs are known to 10 % and 50 %."""

    def deviation(standard, read, random, systematic, expansion, mean, cycle, expansions, temperatures):
        warmer = expansions * (mean + cycle) + expansion * temperatures
        return standard + read + random + systematic - standard * warmer - 50e6

    first = pd_.propagate(deviation, GAUGE_BLOCK, coverage=0.99)
    assert [round(x) for x in (first.value, first.u, *first.interval)] == [838, 32, 745, 931]
    assert round(pd_.propagate(deviation, GAUGE_BLOCK, second_order=True).u) == 34
    drawn = pd_.monte_carlo(deviation, GAUGE_BLOCK, coverage=0.99, trials=1_000_000)
    assert (drawn.value, drawn.u) == pytest.approx((838.0, 36.0), abs=0.5)
    assert drawn.shortest == pytest.approx((745.0, 932.0), abs=1.5)


@pytest.mark.parametrize("distribution", ["rectangular", "triangular", "arcsine"])
def test_ends_that_are_not_exactly_known_widen_what_is_drawn(distribution):
    """A half-width within w (1 +- d) multiplies the variance by 1 + d^2 / 3, with d = 1 / sqrt(2 dof)."""
    known = NORMAL.within("known", 0.0, 1.0, distribution)
    vague = NORMAL.within("vague", 0.0, 1.0, distribution, dof=2.0)
    exact, wide = (pd_.monte_carlo(lambda x: x, (each,), trials=400_000) for each in (known, vague))
    assert exact.u == pytest.approx(known.u, rel=5e-3)
    assert wide.u == pytest.approx(vague.u * math.sqrt(1.0 + 0.25 / 3.0), rel=5e-3)
    assert abs(exact.draws).max() <= 1.0 < abs(wide.draws).max() <= 1.5
