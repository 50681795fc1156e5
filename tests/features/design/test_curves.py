"""The curves of a picture hold what the cases of a report hold."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from platform_daemon.features.design.checked_defect import checked_defect
from platform_daemon.features.design.curves import ForceCurves, force_curves
from platform_daemon.features.design.schema import DefectsRequest


def curves(**asked: Any) -> ForceCurves:
    request = {"bearing": "jewel", "defect": "stator_tilt", "eps_deg": [2.0], **asked}
    return force_curves(checked_defect(DefectsRequest.model_validate(request)))


def test_a_curve_ends_at_the_largest_size_and_the_family_holds_the_bearing_that_was_asked_for() -> None:
    found = curves(eps_deg=[-2.0, 1.0], phi_deg=[10.0, 30.0], cup_radius_over_r=3.0)
    assert found.size[-1] == 2.0
    assert found.phi_deg.tolist() == [10.0, 30.0]
    assert found.family_phi_deg == 30.0
    own = found.spans_over_r.index(3.0)
    np.testing.assert_array_equal(found.family_force_n[:, own], found.force_n[:, 1])
    assert found.weight_n == pytest.approx(1.082e-3, abs=5e-7)


def test_many_deflections_are_a_grid() -> None:
    found = curves(phi_deg=[float(k) for k in range(0, 90, 5)])
    assert found.force_n.shape == (101, 101)
    assert (found.phi_deg[0], found.phi_deg[-1]) == (0.0, 85.0)


def test_where_the_rotor_comes_to_rest_nowhere_a_curve_ends() -> None:
    found = curves(defect="jewel_tilt", eps_deg=[70.0], cup_radius_over_r=4.0)
    flat = found.family_force_n[:, found.spans_over_r.index(math.inf)]
    assert np.all(np.isfinite(found.force_n))
    last = int(np.flatnonzero(np.isfinite(flat))[-1])
    assert 55 < found.size[last] < 65
    assert np.all(np.isnan(flat[last + 1 :]))


def test_sizes_of_nothing_but_zero_have_a_picture_all_the_same() -> None:
    assert curves(eps_deg=[0.0]).size[-1] == 1.0
