"""Design values follow the paper's equations; the simulated world, which shares no line with them, has the same."""

from __future__ import annotations

import math

import pytest

from drivers.specimen import Specimen
from platform_daemon.core.settings import load_specimen
from platform_daemon.design.equations import expected_inertia, expected_moment, expected_omega
from sim_backend.rotor.rotor import design

NAMES = ["thread", "jewel"]


def specimen(name: str) -> Specimen:
    return load_specimen(name)[0]


def never_measured(name: str) -> Specimen:
    shipped = specimen(name)
    none = shipped.measured.model_copy(update={"f_nat_hz": None, "m_r_am2": None})
    return shipped.model_copy(update={"measured": none})


@pytest.mark.parametrize("name", NAMES)
def test_design_values_are_those_of_the_paper(name: str) -> None:
    planned = never_measured(name)
    assert expected_inertia(planned) == pytest.approx(9.924e-11, rel=1e-4)
    assert expected_moment(planned) == pytest.approx(14.625e-3, rel=1e-4)
    assert expected_omega(planned) / (2 * math.pi) == pytest.approx(229.31, abs=0.005)


@pytest.mark.parametrize("name", NAMES)
def test_the_simulated_world_has_the_same_by_equations_of_its_own(name: str) -> None:
    planned = never_measured(name)
    theirs = design(planned)
    assert expected_inertia(planned) == pytest.approx(theirs.inertia_kg_m2, rel=1e-9)
    assert expected_moment(planned) == pytest.approx(theirs.m_r_am2, rel=1e-9)
    assert expected_omega(planned) == pytest.approx(2 * math.pi * theirs.f_nat_hz, rel=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_what_was_measured_is_expected_again(name: str) -> None:
    measured = specimen(name).measured
    assert expected_moment(specimen(name)) == measured.m_r_am2
    assert expected_omega(specimen(name)) == pytest.approx(2 * math.pi * measured.f_nat_hz)
