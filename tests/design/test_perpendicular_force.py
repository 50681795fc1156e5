"""What the paper claims of the equivalent perpendicular force, claim by claim; an independent computation agrees."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from platform_daemon.design.equations import PAPER_MAGNETS, weight
from platform_daemon.design.geometry import Bearing, Defect, DefectKind, StaticResonator
from platform_daemon.design.perpendicular_force import NoEquilibrium, StaticAnalysis, static_analysis
from tests.kit.static_opponent import B_R, Case, D, R

PAPER = {"jewel": 5 / 3, "thread": 8.0}
KINDS: list[tuple[Bearing, Defect]] = [
    ("jewel", "stator_tilt"), ("jewel", "jewel_tilt"), ("jewel", "lateral"),
    ("thread", "stator_tilt"), ("thread", "rotor_tilt"), ("thread", "lateral"),
]  # fmt: skip
TILTS = [(b, d) for b, d in KINDS if d != "lateral"]


def resonator(bearing: Bearing, span_over_r: float | None = None, size: float = 1.0) -> StaticResonator:
    span = PAPER[bearing] if span_over_r is None else span_over_r
    return StaticResonator(bearing, size * R, B_R, size * D, size * span * R)


def sizes(defect: Defect, *values: float) -> list[float]:
    """Degrees of a tilt, mm of a displacement, in rad and m."""
    return [v * 1e-3 if defect == "lateral" else math.radians(v) for v in values]


def analysed(bearing: Bearing, defect: Defect, values: Any, phi_deg: Any = (30.0,), **keys: Any) -> StaticAnalysis:
    span, size = keys.pop("span", None), keys.pop("size", 1.0)
    kind = DefectKind(bearing, defect, **keys)
    return static_analysis(resonator(bearing, span, size), kind, sizes(defect, *values), np.radians(phi_deg))


def forces(*arguments: Any, **keys: Any) -> NDArray[np.float64]:
    """F_perp, mN, sizes by deflections."""
    return analysed(*arguments, **keys).perpendicular_force_n * 1e3


@pytest.mark.parametrize(("bearing", "expected"), [("jewel", 5.850), ("thread", 6.776)])
def test_two_degrees_of_stator_tilt_at_30_degrees(bearing: Bearing, expected: float) -> None:
    assert forces(bearing, "stator_tilt", [2.0])[0, 0] == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize(("bearing", "defect"), KINDS)
def test_without_a_defect_the_force_vanishes_identically(bearing: Bearing, defect: Defect) -> None:
    for span in (PAPER[bearing], 100.0, math.inf):
        found = analysed(bearing, defect, [0.0], np.linspace(-90, 90, 37), span=span)
        assert np.all(found.perpendicular_force_n == 0)
        assert found.displacement_m[0] == 0
        assert found.alpha_rad[0] == pytest.approx(math.pi / 2, abs=1e-15)


@pytest.mark.parametrize(("bearing", "about"), [("jewel", 0.36), ("thread", 0.32)])
def test_small_errors_already_give_forces_like_gravity(bearing: Bearing, about: float) -> None:
    eps = np.linspace(0, 1, 201)
    force = forces(bearing, "stator_tilt", eps)[:, 0]
    assert np.interp(weight(PAPER_MAGNETS) * 1e3, force, eps) == pytest.approx(about, abs=0.005)


@pytest.mark.parametrize(("bearing", "defect"), KINDS)
def test_larger_deflections_give_larger_forces(bearing: Bearing, defect: Defect) -> None:
    force = forces(bearing, defect, [0.2, 1.0, 2.0], np.linspace(0, 90, 46))
    assert np.all(np.diff(force, axis=1) > 0)


@pytest.mark.parametrize("bearing", PAPER)
def test_the_thread_has_a_force_without_deflection_and_the_jewel_has_none(bearing: Bearing) -> None:
    at_rest = forces(bearing, "stator_tilt", [2.0], [0.0])[0, 0]
    assert at_rest == pytest.approx(0, abs=1e-9) if bearing == "jewel" else at_rest > 3


def test_the_force_grows_with_the_cup_up_to_5_degrees_and_no_further() -> None:
    spans = [1.1, 5 / 3, 2, 4, 10, 100, 1000, math.inf]
    by_span = np.array([forces("jewel", "stator_tilt", [0.1, 1.0, 2.0, 4.5, 5.0, 10.0], span=s)[:, 0] for s in spans])
    growth = np.diff(by_span, axis=0) / by_span[1:]
    assert np.all(growth[:, :4] > 0)
    assert np.all(growth[:, 4] > -1e-4)  # at 5 deg it has its largest value at R = 300 r, by less than that
    assert growth[-1, 5] < 0
    assert by_span[3, 5] > 1.04 * by_span[-1, 5]


def test_a_flat_jewel_is_most_sensitive_in_the_first_few_degrees() -> None:
    force = forces("jewel", "stator_tilt", [0.0, 1.0, 10.0], span=math.inf)[:, 0]
    assert force[1] > 0.75 * force[2]
    curved = forces("jewel", "stator_tilt", [0.0, 1.0, 10.0])[:, 0]
    assert curved[1] < 0.15 * curved[2]


def test_a_longer_thread_increases_the_force_slightly() -> None:
    spans = [2.0, 4.0, 8.0, 16.0, math.inf]
    force = np.array([forces("thread", "stator_tilt", [1.0, 2.0, 5.0], span=s)[:, 0] for s in spans])
    assert np.all(np.diff(force, axis=0) > 0)
    assert np.all(force[-1] < 1.3 * force[1])


@pytest.mark.parametrize(("bearing", "defect"), [("jewel", "jewel_tilt"), ("thread", "rotor_tilt")])
def test_the_other_tilts_resemble_that_of_the_stator(bearing: Bearing, defect: Defect) -> None:
    """Curves over eps have the same shape; at 30 deg they are 0.44 times as high."""
    eps = np.linspace(0.1, 5, 20)
    for phi in (10.0, 30.0, 60.0):
        ratio = forces(bearing, defect, eps, [phi]) / forces(bearing, "stator_tilt", eps, [phi])
        assert np.ptp(ratio) < 0.08 * ratio.mean()
        assert 0.2 < ratio.min() < ratio.max() < 0.6
    at_30 = forces(bearing, defect, [0.1])[0, 0] / forces(bearing, "stator_tilt", [0.1])[0, 0]
    assert at_30 == pytest.approx(0.44, abs=0.005)


@pytest.mark.parametrize(("bearing", "spans"), [("jewel", [5 / 3, 4.0, 1e2, 1e4]), ("thread", [1.0, 8.0, 1e2, 1e4])])
def test_the_force_of_a_displacement_falls_with_the_span_and_vanishes_for_an_infinite_one(
    bearing: Bearing, spans: list[float]
) -> None:
    force = [forces(bearing, "lateral", [0.5], span=s)[0, 0] for s in spans]
    assert np.all(np.diff(force) < 0)
    found = analysed(bearing, "lateral", [0.1, 0.5, 1.0], [0.0, 30.0, 60.0], span=math.inf)
    assert np.all(found.perpendicular_force_n < 1e-8)
    assert found.displacement_m == pytest.approx([1e-4, 5e-4, 1e-3], rel=1e-5)


@pytest.mark.parametrize("bearing", PAPER)
def test_a_displacement_across_the_magnetisation_gives_none(bearing: Bearing) -> None:
    force = forces(bearing, "lateral", [0.2, 1.0, 3.0], np.linspace(0, 90, 10), direction="across")
    assert np.all(force < 1e-8)


def test_a_jewel_tilted_about_the_stator_is_a_stator_that_is_tilted() -> None:
    eps, phi = np.linspace(-20, 20, 41), np.linspace(0, 90, 10)
    for span in (1.2, 5 / 3, 10.0, math.inf):
        jewel = analysed("jewel", "jewel_tilt", eps, phi, pivot="stator_centre", span=span)
        stator = analysed("jewel", "stator_tilt", -eps, phi, span=span)
        np.testing.assert_allclose(jewel.perpendicular_force_n, stator.perpendicular_force_n, rtol=1e-7, atol=1e-11)
        np.testing.assert_allclose(jewel.displacement_m, stator.displacement_m, rtol=1e-6, atol=1e-12)
        np.testing.assert_allclose(jewel.alpha_rad, stator.alpha_rad, rtol=1e-7)


def test_the_tilt_of_a_stator_is_a_superposition_of_jewel_tilt_and_displacement() -> None:
    """To first order: about the stator = about the contact, and the contact moved by eps (d - r)."""
    eps = 1e-4
    lever = D - R

    def tilting(found: StaticAnalysis) -> NDArray[np.float64]:
        about_d = found.torque_nm[0, 0] + np.cross(found.centre_m - found.reference_point_m, found.force_n[0, 0])[0]
        return about_d - (about_d @ found.axis[0]) * found.axis[0]

    cup = resonator("jewel")
    phi = [math.radians(30)]
    stator = tilting(static_analysis(cup, DefectKind("jewel", "stator_tilt"), [eps], phi))
    tilt = tilting(static_analysis(cup, DefectKind("jewel", "jewel_tilt"), [-eps], phi))
    shift = tilting(static_analysis(cup, DefectKind("jewel", "lateral"), [-eps * lever], phi))
    np.testing.assert_allclose(stator, tilt + shift, rtol=2e-3, atol=1e-3 * np.abs(stator).max())


@pytest.mark.parametrize(("bearing", "defect"), KINDS)
def test_every_defect_moves_the_rotor_and_tilts_its_moment(bearing: Bearing, defect: Defect) -> None:
    found = analysed(bearing, defect, [1.0 if defect == "lateral" else 10.0])
    assert found.displacement_m[0] > 1e-5
    assert abs(math.degrees(found.alpha_rad[0]) - 90) > 1


@pytest.mark.parametrize(("bearing", "defect"), KINDS)
def test_the_sign_of_a_defect_and_of_the_deflection_does_not_matter(bearing: Bearing, defect: Defect) -> None:
    force = forces(bearing, defect, [-1.0, 1.0], [-40.0, 40.0])
    np.testing.assert_allclose(force, force[0, 0], rtol=1e-8)


@pytest.mark.parametrize("size", [0.01, 100.0])
@pytest.mark.parametrize(("bearing", "defect"), TILTS)
def test_forces_scale_with_the_second_power_of_the_size(bearing: Bearing, defect: Defect, size: float) -> None:
    was, now = (analysed(bearing, defect, [1.0, 5.0], [10.0, 30.0], size=s) for s in (1.0, size))
    np.testing.assert_allclose(now.perpendicular_force_n, size**2 * was.perpendicular_force_n, rtol=1e-9)
    np.testing.assert_allclose(now.displacement_m, size * was.displacement_m, rtol=1e-9)
    np.testing.assert_allclose(now.alpha_rad, was.alpha_rad, rtol=1e-9)


@pytest.mark.parametrize(("bearing", "defect"), KINDS)
@pytest.mark.parametrize("span", [None, pytest.param(3.0, marks=pytest.mark.long)])
def test_brute_force_by_angles_and_differences_of_energy_finds_the_same(
    bearing: Bearing, defect: Defect, span: float | None
) -> None:
    for value, phi in ((0.5, 20.0), (3.0 if defect == "lateral" else 12.0, 70.0)):
        found = analysed(bearing, defect, [value], [phi], span=span)
        other = Case(bearing, defect, sizes(defect, value)[0], (span or PAPER[bearing]) * R)
        force, alpha = other.perpendicular_force(math.radians(phi))
        assert found.perpendicular_force_n[0, 0] == pytest.approx(force, rel=2e-5)
        assert found.alpha_rad[0] == pytest.approx(alpha, abs=1e-5)


@pytest.mark.parametrize(("pivot", "height"), [("rotor_centre", D), ("stator_centre", 0.0)])
def test_brute_force_finds_the_same_for_other_pivots(pivot: Any, height: float) -> None:
    force, _ = Case("jewel", "jewel_tilt", math.radians(6), PAPER["jewel"] * R, height).perpendicular_force(0.5)
    found = static_analysis(resonator("jewel"), DefectKind("jewel", "jewel_tilt", pivot), [math.radians(6)], [0.5])
    assert found.perpendicular_force_n[0, 0] == pytest.approx(force, rel=2e-5)


@pytest.mark.parametrize(("bearing", "defect"), KINDS)
def test_infinite_spans_are_the_limit_of_large_ones(bearing: Bearing, defect: Defect) -> None:
    near, far = (forces(bearing, defect, [2.0], span=s)[0, 0] for s in (1e6, math.inf))
    assert near == pytest.approx(far, rel=2e-3, abs=1.0 if (bearing, defect) == ("jewel", "lateral") else 1e-3)


def test_where_nothing_holds_the_rotor_the_first_such_size_is_named() -> None:
    with pytest.raises(NoEquilibrium) as refused:
        analysed("jewel", "jewel_tilt", [1.0, 70.0, 80.0], span=math.inf)
    assert math.degrees(refused.value.size) == pytest.approx(70)
    assert "touch the stator" in refused.value.reason


@pytest.mark.parametrize(("bearing", "defect"), [("thread", "jewel_tilt"), ("jewel", "rotor_tilt")])
def test_defects_that_a_bearing_cannot_have(bearing: Bearing, defect: Defect) -> None:
    with pytest.raises(ValueError, match=r"jewel|attached"):
        DefectKind(bearing, defect)


@pytest.mark.parametrize(
    ("bearing", "span", "word"),
    [
        ("jewel", 1.0, "fit"),
        ("jewel", -2.0, "fit"),
        ("thread", 0.0, "positive"),
        ("thread", math.nan, "positive"),
        ("jewel", 1 + 1e-12, "play"),
        ("thread", 1e-12, "play"),
    ],
)
def test_bearings_that_do_not_exist(bearing: Bearing, span: float, word: str) -> None:
    with pytest.raises(ValueError, match=word):
        resonator(bearing, span)


def test_magnets_that_overlap_or_are_none() -> None:
    with pytest.raises(ValueError, match="overlap"):
        StaticResonator("thread", 1.5e-3, 1.3, 2.9e-3, 12e-3)
    with pytest.raises(ValueError, match="remanence"):
        StaticResonator("thread", 1.5e-3, math.inf, 4.7e-3, 12e-3)
