"""A line within the width of a side mode may be what is left of that until its place is exact."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from platform_daemon.diagnosis.effects.additive import LINE, side_mode, tone
from platform_daemon.diagnosis.selection.stepwise import in_an_oscillation


@pytest.mark.parametrize(
    ("mode_hz", "line_hz", "within"),
    [
        pytest.param(1.9752, 1.9748, True, id="record 62 of the angle study"),
        pytest.param(1.9752, 2.2, False, id="beside the mode"),
        pytest.param(None, 1.9748, False, id="no mode"),
    ],
)
def test_a_line_within_a_side_mode_may_be_a_part_of_it(mode_hz, line_hz, within):
    mode = [] if mode_hz is None else [side_mode(mode_hz, 35.0, 0, 1, shared=False, trials=1.0)]
    at: Any = SimpleNamespace(
        hypothesis=SimpleNamespace(effects=mode), prepared=[SimpleNamespace(time_s=np.array([0.0, 114.0]))]
    )
    assert in_an_oscillation(tone(LINE, (line_hz,), line_hz, 1.0), at) == within
