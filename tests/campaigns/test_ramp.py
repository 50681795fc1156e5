"""Two ramps of the study; `python -m tests.campaigns.ramp` does all."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.campaigns.ramp import CASES, Rotor, ramp, told


@pytest.mark.long
def test_a_ramp_of_the_study_ends_near_the_threshold_of_the_world() -> None:
    case = replace(CASES[0], span_ut=(200, 320))
    rotor = Rotor(case)
    true_ut = rotor.threshold_ut(case.span_ut)
    assert true_ut == pytest.approx(270.0, abs=5.0)  # the paper's
    found = ramp(case, rotor, seed=3)
    assert found.threshold is not None
    assert found.threshold[0] == pytest.approx(true_ut, abs=10.0)
    assert found.highest < true_ut + 10.0
    assert told(case, true_ut, [found]).count("|") == 9


@pytest.mark.long
def test_a_rotor_without_side_modes_stops_no_ramp() -> None:
    case = replace(next(c for c in CASES if c.specimen == "thread"), span_ut=(250, 300))
    found = ramp(case, Rotor(case), seed=1)
    assert (found.stopped, found.threshold, found.highest) == (False, None, 300.0)
