"""How a tuned number is declared: its value, its unit, what it means, and what set it."""

from __future__ import annotations

from dataclasses import field
from typing import TypeVar

NOT_STUDIED = "not set by a study"
_T = TypeVar("_T")


def tuned(value: _T, unit: str, meaning: str, source: str = NOT_STUDIED) -> _T:
    """A field of a dataclass of thresholds; unit, meaning and source are in its metadata.

    Args:
        value: the number, or several as a tuple.
        unit: SI unit, what is counted, "sd" for standard deviations, or "1".
        meaning: completes the name of the field.
        source: the study, test, paper or false-alarm rate that set it; nothing did where it is left out.
    """
    found: _T = field(default=value, metadata={"unit": unit, "meaning": meaning, "source": source})
    return found


def false_alarm(rate: str) -> str:
    """The source of a limit that follows from how often Gaussian noise exceeds it."""
    return f"false-alarm rate of Gaussian noise: {rate}"


def covered_by(test: str) -> str:
    """The source of a number that no study set, while a test under tests/estimation covers what it decides."""
    return f"{NOT_STUDIED}; covered by tests/estimation/{test}"
