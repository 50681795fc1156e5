"""How far a number may be from its golden value on another computer, whose last bits differ; with the reasons."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any

RELATIVE = 1e-6
OF_STD = 1e-3  # an estimate is where the search stops, a small share of its own standard deviation from the minimum

_PICTURE = re.compile(r"/missing_torque/(?:value|std)/\d+/\d+$")
# (JSON pointer, relative, absolute): the first that fits.
_LOOSER = (
    # The scatter of frames, and what is predicted through a nearly singular matrix, are differences of large numbers.
    (re.compile(r"/summary/\w+/std$|/expected_sigma$"), 1e-4, 0.0),
    # A chance is exp(-chi2/2): what chi2 has in its last digits the chance has in its first.
    (re.compile(r"/p_value$|/probability$"), 1e-3, 0.0),
    # Two frames lie on opposite sides of their mean: the scatter of their distances is rounding and nothing else.
    (re.compile(r"/orientation_error/against_mean/std_rad$"), RELATIVE, 1e-12),
    # A picture in units of its largest value; empty where no sample came, which at its edge is a matter of rounding.
    (_PICTURE, 0.0, 1e-4),
    (re.compile(r"/missing_torque/\w+/\d+$"), RELATIVE, 1e-12),  # its axes go through zero
    # A recording holds numbers as text too, as long as their digits.
    (re.compile(r"/size_bytes$"), 0.0, 100.0),
)
_DIGEST = re.compile(r"/digest$")
_RANKING = re.compile(r"/ranking$")


def is_close(was: Any, now: Any, pointer: str, std: float = 0.0) -> bool:
    """Are two numbers the same but for rounding?  std: standard deviation of an estimate, 0: none."""
    if isinstance(was, str):
        return _DIGEST.search(pointer) is not None and len(was) == len(now)  # of numbers to their last bit
    relative, absolute = next(((r, a) for p, r, a in _LOOSER if p.search(pointer)), (RELATIVE, OF_STD * std))
    if isinstance(was, float) or absolute:
        return math.isclose(was, now, rel_tol=relative, abs_tol=absolute)
    return bool(was == now)


def number_for_nothing(value: Any, pointer: str) -> Any:
    """0 for the empty place of a picture, else the value."""
    return 0.0 if value is None and _PICTURE.search(pointer) else value


def in_any_order(entries: Sequence[Any], pointer: str) -> list[Any]:
    """A ranking sorted by names: what explains the data equally well comes in the order of its last bits."""
    if not _RANKING.search(pointer):
        return list(entries)
    gains = [{"gain": entry.get("gain")} for entry in entries]
    return gains + sorted(entries, key=lambda entry: str([v for k, v in entry.items() if k not in ("gain", "p_value")]))
