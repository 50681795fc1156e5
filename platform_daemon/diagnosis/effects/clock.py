"""A gap in the clock is no physics: it is found by data_integrity.py, mended, and reported under its name."""

from __future__ import annotations

from .effect import Candidate, Detail, Effect

GAP = Effect(
    "clock_gap", "samples", 1, (), "the phase steps at one sample", "samples that the card or its link has lost",
)  # fmt: skip


def gap(sample: int) -> Candidate:
    """A gap before this sample."""
    return Candidate(GAP, Detail(sample=sample))
