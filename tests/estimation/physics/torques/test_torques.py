"""Every torque term against differences of itself: its derivatives, its symmetry, its number, its energy."""

import math
import re

import numpy as np
import pytest

from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.torques import AUTONOMOUS, IN_PLACE, SEPARATE, TERMS, TIMED, code_of
from platform_daemon.estimation.physics.torques.dispatch import acceleration, timed_acceleration
from platform_daemon.estimation.physics.torques.frequency_drift import FREQUENCY_DRIFT
from platform_daemon.estimation.physics.torques.frequency_settling import FREQUENCY_SETTLING
from platform_daemon.estimation.physics.torques.linear_restoring import LINEAR_RESTORING
from platform_daemon.estimation.physics.torques.magnetic_restoring import MAGNETIC_RESTORING

STATES = [(0.3, 0.2), (-1.2, 0.9), (1.0, 1e-3), (-0.05, 1.6)]  # phi, |v|; nowhere a kink
U = 37.0
LAWS = {**TERMS, **{term.function.__name__: term for term in IN_PLACE}}
ALL = pytest.mark.parametrize("term", LAWS.values(), ids=LAWS)
DIRECTIONS = pytest.mark.parametrize("sigma", [1.0, -1.0])


def coefficients_of(term):
    return np.array([c.typical for c in term.coefficients])


def call(term, phi, v, u, sigma, c):
    """(tau, by phi, by v, by u, by c) from the term's own function."""
    grad = np.full(c.size + 1, np.nan)
    function = getattr(term.function, "py_func", term.function)
    moment = (u,) if term.timed else ()
    direction = () if term.timed else (sigma,)
    out = function(phi, math.sin(phi), math.cos(phi), v, *moment, *direction, c, 0, grad)
    return (*out, *([] if term.timed else [0.0]), grad[: c.size])


def slope(function, x, step):
    """Central differences of order six."""
    values = [function(x + k * step) for k in (-3, -2, -1, 1, 2, 3)]
    return float(np.dot([-1, 9, -45, 45, -9, 1], values)) / (60 * step)


@ALL
@DIRECTIONS
@pytest.mark.parametrize(("phi", "speed"), STATES)
def test_a_term_knows_its_own_derivatives(term, sigma, phi, speed):
    c, v = coefficients_of(term), sigma * speed
    tau, by_phi, by_v, by_u, by_c = call(term, phi, v, U, sigma, c)
    size = max(abs(tau), 1e-9)
    assert by_phi == pytest.approx(
        slope(lambda x: call(term, x, v, U, sigma, c)[0], phi, 1e-3), abs=1e-8 * size + 1e-12
    )
    step = 1e-4 * max(1.0, speed)
    assert by_v == pytest.approx(slope(lambda x: call(term, phi, x, U, sigma, c)[0], v, step), abs=1e-7 * size + 1e-12)
    assert by_u == pytest.approx(slope(lambda x: call(term, phi, v, x, sigma, c)[0], U, 0.1), abs=1e-7 * size + 1e-14)
    for k in range(c.size):

        def along(x, k=k):
            moved = c.copy()
            moved[k] = x
            return call(term, phi, v, U, sigma, moved)[0]

        assert by_c[k] == pytest.approx(slope(along, c[k], 0.02 * c[k]), rel=1e-6, abs=1e-12)


@ALL
def test_a_term_is_its_own_mirror_image_exactly_if_it_says_so(term):
    c = coefficients_of(term)
    mirrored = [
        call(term, -phi, -v, U, -math.copysign(1, v), c)[0]
        == pytest.approx(-call(term, phi, v, U, math.copysign(1, v), c)[0])
        for phi, v in STATES
    ]
    assert all(mirrored) if term.symmetric else not any(mirrored)


@ALL
@DIRECTIONS
def test_a_term_loses_energy_exactly_if_it_says_so(term, sigma):
    """Over a symmetric half cycle: conservative torques give back what they took."""
    c, amplitude = coefficients_of(term), 1.1
    phi = sigma * amplitude * np.cos(np.pi * (np.arange(400) + 0.5) / 400)
    v = sigma * np.sqrt(2 * (np.cos(phi) - math.cos(amplitude)))
    torque = [call(term, p, x, 0.0, sigma, c)[0] for p, x in zip(phi, v, strict=True)]
    work = -float(np.dot(torque, sigma * amplitude * np.sin(np.pi * (np.arange(400) + 0.5) / 400)))
    if term.loses_energy:
        assert work > 1e-6
    elif term.symmetric and not term.timed:
        assert abs(work) < 1e-12


@ALL
@DIRECTIONS
def test_the_dispatch_finds_a_term_by_its_number(term, sigma):
    model = RingDownModel("one term", (term,))
    c, grad = coefficients_of(term), np.full(len(term.coefficients) + 1, np.nan)
    phi, v = -0.7, 0.4 * sigma
    if term.timed:
        found = timed_acceleration(phi, v, U, sigma, model.codes, model.widths, c, grad)
        assert acceleration(phi, v, sigma, model.codes, model.widths, c, grad.copy()) == (0.0, 0.0, 0.0)
    else:
        found = (*acceleration(phi, v, sigma, model.codes, model.widths, c, grad), 0.0)
        assert timed_acceleration(phi, v, U, sigma, model.codes, model.widths, c, grad.copy()) == (0.0, 0.0, 0.0, 0.0)
    expected = call(term, phi, v, U, sigma, c)
    assert found == pytest.approx(expected[:4], rel=1e-14)
    assert grad[: c.size] == pytest.approx(expected[4], rel=1e-14)


@pytest.mark.parametrize("term", [FREQUENCY_DRIFT, FREQUENCY_SETTLING], ids=lambda term: term.name)
def test_a_frequency_that_moves_moves_the_restoring_torque_that_is_declared(term):
    c, grad, phi = coefficients_of(term), np.zeros(4), 0.8
    pendulum, spring = (
        timed_acceleration(phi, 0.7, U, 1.0, model.codes, model.widths, c, grad.copy())
        for model in (RingDownModel("moved", (law, term)) for law in (MAGNETIC_RESTORING, LINEAR_RESTORING))
    )
    ratio = phi / math.sin(phi)
    assert spring == pytest.approx((ratio * pendulum[0], pendulum[1] / math.cos(phi), 0.0, ratio * pendulum[3]))


def test_the_dispatch_adds_terms_and_keeps_their_coefficients_apart():
    model = RingDownModel("all", (*(term for term in AUTONOMOUS if term is not LINEAR_RESTORING), *TIMED))
    c = np.array([q.typical for q in model.coefficients])
    grad = np.zeros(c.size + 1)
    total = acceleration(0.4, 0.7, 1.0, model.codes, model.widths, c, grad)[0]
    total += timed_acceleration(0.4, 0.7, U, 1.0, model.codes, model.widths, c, grad)[0]
    alone = [call(t, 0.4, 0.7, U, 1.0, coefficients_of(t)) for t in model.terms]
    assert total == pytest.approx(sum(a[0] for a in alone), rel=1e-13)
    assert grad[:-1] == pytest.approx(np.concatenate([a[4] for a in alone]), rel=1e-13)


def test_names_of_terms_and_coefficients_are_unique_and_have_units():
    coefficients = [c for term in TERMS.values() for c in term.coefficients]
    assert len({c.name for c in coefficients}) == len(coefficients)
    assert len(TERMS) == len(AUTONOMOUS) + len(TIMED) + len(SEPARATE)
    assert len({code_of(term) for term in TERMS.values()}) == len(TERMS)
    for c in coefficients:
        assert c.unit
        assert c.power == per_second(c.unit)


def per_second(unit):
    """Power of 1/s in a unit as text: -1 of s, 2 of rad/s^2."""
    above, _, below = unit.partition("/")
    return sum(
        sign * int(power or 1)
        for sign, part in ((-1, above), (1, below))
        for power in re.findall(r"(?:^|\s)s(?:\^(\d))?(?=\s|$)", part)
    )


def test_the_power_of_a_coefficient_follows_from_its_unit():
    units = {"1": 0, "1/rad": 0, "s": -1, "s^2": -2, "1/s": 1, "rad/s": 1, "rad/s^2": 2, "A m^2": 0, "kg m^2/s": 1}
    assert {unit: per_second(unit) for unit in units} == units
