"""The design equations give the paper's numbers, except for T_f, which needs another mu than the printed one."""

from __future__ import annotations

import math

import pytest

from drivers.specimen import Magnets
from platform_daemon.core.settings import load_specimen
from platform_daemon.design.equations import (
    PAPER_JEWEL,
    PAPER_MAGNETS,
    PAPER_THREAD,
    PRINTED_FRICTION_RAD_PER_S2,
    PRINTED_FRICTION_TORQUE_NM,
    design_numbers,
    friction_coefficient_of,
    friction_increase,
    moment_of_inertia,
)


def scaled(magnets: Magnets, by: float) -> Magnets:
    return magnets.model_copy(update={"radius_m": by * magnets.radius_m, "distance_m": by * magnets.distance_m})


def test_the_numbers_of_the_paper() -> None:
    found = design_numbers(PAPER_MAGNETS, PAPER_JEWEL)
    assert found.m_r_am2 == pytest.approx(14.625e-3, abs=5e-7)
    assert found.f_nat_hz == pytest.approx(229.31, abs=0.005)
    assert found.f_m_n == pytest.approx(131.50e-3, abs=5e-6)
    assert found.f_g_n == pytest.approx(1.082e-3, abs=5e-7)
    assert found.inertia_kg_m2 == pytest.approx(9.924e-11, rel=1e-4)
    assert found.b_0_t == pytest.approx(14.09e-3, abs=5e-6)
    # eq:omega_nat and eq:fnat are two ways to the same frequency.
    omega = math.sqrt(found.m_r_am2 * found.b_0_t / found.inertia_kg_m2)
    assert omega == pytest.approx(2 * math.pi * found.f_nat_hz, rel=1e-9)


def test_the_printed_friction_follows_from_another_mu_than_the_printed_one() -> None:
    friction = design_numbers(PAPER_MAGNETS, PAPER_JEWEL).friction
    assert friction is not None
    assert friction.friction_torque_nm == pytest.approx(144.9e-9, abs=5e-11)
    assert friction.friction_rad_per_s2 == pytest.approx(1460, abs=0.5)
    by_torque = friction_coefficient_of(PRINTED_FRICTION_TORQUE_NM, PAPER_MAGNETS, PAPER_JEWEL)
    per_inertia = PRINTED_FRICTION_RAD_PER_S2 * moment_of_inertia(PAPER_MAGNETS)
    assert by_torque == pytest.approx(0.1200, abs=5e-5)
    assert friction_coefficient_of(per_inertia, PAPER_MAGNETS, PAPER_JEWEL) == pytest.approx(0.1200, abs=5e-5)


@pytest.mark.parametrize(("k", "expected"), [(5 / 3, 1.3572), (2, 1.2599), (4, 1.1006), (math.inf, 1.0)])
def test_lambda(k: float, expected: float) -> None:
    assert friction_increase(k) == pytest.approx(expected, abs=5e-5)


@pytest.mark.parametrize("k", [1.0, 0.5, -2.0, math.nan])
def test_a_cup_into_which_the_rotor_does_not_fit_has_no_lambda(k: float) -> None:
    with pytest.raises(ValueError, match="larger than the rotor's"):
        friction_increase(k)


@pytest.mark.parametrize("by", [0.1, 1 / 3, 10.0])
def test_size_changes_the_frequency_and_not_the_quality(by: float) -> None:
    cup = PAPER_JEWEL.model_copy(update={"cup_radius_m": by * PAPER_JEWEL.cup_radius_m})
    was, now = design_numbers(PAPER_MAGNETS, PAPER_JEWEL), design_numbers(scaled(PAPER_MAGNETS, by), cup)
    assert was.friction is not None
    assert now.friction is not None
    assert now.friction.quality_factor_per_rad == pytest.approx(was.friction.quality_factor_per_rad, rel=1e-12)
    assert now.friction.friction_increase == pytest.approx(was.friction.friction_increase, rel=1e-12)
    assert now.b_0_t == pytest.approx(was.b_0_t, rel=1e-12)
    assert now.friction.friction_torque_nm == pytest.approx(by**3 * was.friction.friction_torque_nm, rel=1e-12)
    assert now.friction.contact_radius_m == pytest.approx(by * was.friction.contact_radius_m, rel=1e-12)
    assert now.f_m_n == pytest.approx(by**2 * was.f_m_n, rel=1e-12)
    assert now.f_nat_hz == pytest.approx(was.f_nat_hz / by, rel=1e-12)


def test_the_quality_factor_is_that_of_the_appendix() -> None:
    found = design_numbers(PAPER_MAGNETS, PAPER_JEWEL)
    assert found.friction is not None
    amplitude = 0.5
    stored = found.m_r_am2 * found.b_0_t * amplitude**2 / 2
    lost = 4 * found.friction.friction_torque_nm * amplitude
    assert found.friction.quality_factor_per_rad == pytest.approx(2 * math.pi * stored / lost / amplitude)


def test_without_friction_the_quality_has_no_bound() -> None:
    smooth = PAPER_JEWEL.model_copy(update={"friction_coefficient": 0.0})
    friction = design_numbers(PAPER_MAGNETS, smooth).friction
    assert friction is not None
    assert friction.friction_torque_nm == 0
    assert friction.quality_factor_per_rad is None


def test_the_shipped_resonators_are_at_the_design_point_of_the_paper() -> None:
    jewel, thread = load_specimen("jewel")[0], load_specimen("thread")[0]
    assert jewel.magnets == thread.magnets == PAPER_MAGNETS
    assert jewel.jewel == PAPER_JEWEL
    assert thread.thread == PAPER_THREAD
