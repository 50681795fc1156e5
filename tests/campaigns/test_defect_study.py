"""The study's judgement of reports, and a case of its own through all of it."""

import math

import pytest

from tests.campaigns.defect_study import Case, drawn, judged, outcome, section

TILTED = Case("jewel", "stator_tilt", math.radians(2.0), 490.0, 1.0, 1)
TRUTH = {"f_nat_hz": 214.0, "m_r_am2": 0.012}


def report(name, alike=(), size=TILTED.size, m_r_am2=0.012):
    return {
        "verdict": "explained",
        "effects": [{"id": name, "strength": {"value": size, "std": 1e-4}, "indistinguishable_from": list(alike)}],
        "parameters_after": {
            "f_nat_hz": {"value": 214.0, "std": 1e-3},
            "m_r_am2": {"value": m_r_am2, "std": 1e-6},
            "rodrigues_x": {"value": 0.0, "std": None},
        },
        "held_out": {"chi2_per_dof_after": 1.0},
        "seconds": 1.0,
    }


def test_the_declared_set_counts_and_the_size_only_where_this_kind_is_named():
    right = judged(TILTED, report("stator_tilt", size=TILTED.size + 2e-4), TRUTH)
    assert right.kind_right
    assert right.size == pytest.approx(2.0)
    assert right.numbers_right
    alike = judged(TILTED, report("jewel_tilt", ["stator_tilt"], size=-0.08), TRUTH)
    assert alike.kind_right
    assert alike.size is None
    assert not judged(TILTED, report("jewel_tilt"), TRUTH).kind_right
    assert not judged(TILTED, report("stator_tilt", size=TILTED.size + 4e-4), TRUTH).numbers_right
    assert not judged(TILTED, report("stator_tilt", m_r_am2=0.012004), TRUTH).numbers_right
    perfect = Case("jewel", "none", 0.0, 490.0, 1.0, 1)
    assert not judged(perfect, report("stator_tilt"), TRUTH).kind_right
    assert judged(perfect, report("side_mode"), TRUTH).kind_right
    page = section([right, alike], 2.0, driven=True)
    assert "Kind named or in the declared set: 2 of 2." in page
    assert "| jewel | stator_tilt 2.000° | 490 | explained: stator_tilt | +2.0 | +0.0 +0.0 | 1.000 | 1 |" in page


def test_cases_are_drawn_within_the_range_and_again_alike():
    cases = drawn(12, 4, 7)
    assert cases == drawn(12, 4, 7)
    assert [c.bearing for c in cases[:2]] == ["thread", "jewel"]
    assert [c.kind for c in cases[12:]] == ["none"] * 4
    for case in cases[:12]:
        largest = 3e-4 if case.kind == "lateral_displacement" else math.radians(3.0)
        assert 0.0 < abs(case.size) <= largest
        assert ("jewel" if case.bearing == "thread" else "rotor_tilt") not in case.kind


@pytest.mark.long
@pytest.mark.parametrize("driven", [True, False])
def test_a_perfect_threads_shot_has_no_error_of_manufacture(driven):
    (perfect,) = drawn(0, 1, 40)
    found = outcome(perfect, 0.4, driven=driven)
    assert found.kind_right
    assert found.verdict == "nothing_missing"


@pytest.mark.long
def test_a_tilted_rotor_is_named_by_a_shot_that_tells_neither_drive_nor_resonator():
    """One angle takes so large a tilt for another orientation and moment, and no fit of it converges."""
    found = outcome(drawn(1, 0, 40)[0], 0.5, driven=False)
    assert found.case.kind == "rotor_tilt"
    assert found.names == ("rotor_tilt",)
    assert found.numbers_right
