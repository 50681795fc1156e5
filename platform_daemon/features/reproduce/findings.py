"""What a campaign has found, and the numbers that are taken from it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from platform_daemon.design.equations import (
    PAPER_JEWEL,
    PAPER_MAGNETS,
    DesignNumbers,
    FrictionNumbers,
    design_numbers,
)
from platform_daemon.features.characterise.schema import CharacterisationReport, CharacteriseOutcome, ShotStatistics
from platform_daemon.features.characterise.side_by_side.noise_schema import BreakEven, NoiseSweepReport


@dataclass(frozen=True)
class Value:
    """A number with its standard error, None: it has none; or a statement."""

    value: float | str
    u: float | None = None


@dataclass(frozen=True)
class Findings:
    """What there is to compare.

    Attributes:
        outcomes: by the variant of a resonator what characterise has made of its shots; one that is missing was not
            measured.
        noise: sweep over thread and jewel, in this order; None: there is none, and why_no_noise says why.
    """

    outcomes: dict[str, CharacteriseOutcome]
    noise: NoiseSweepReport | None = None
    why_no_noise: str = "it was not measured in this campaign"

    def break_even(self, quantity: str) -> BreakEven | None:
        """Of f_nat_hz or orientation; None: there is no sweep."""
        found = () if self.noise is None else self.noise.break_even
        return next((one for one in found if one.quantity == quantity), None)

    @property
    def design(self) -> DesignNumbers:
        """Of the paper's design point."""
        return design_numbers(PAPER_MAGNETS, PAPER_JEWEL)

    @property
    def friction(self) -> FrictionNumbers:
        """Of the paper's jewel."""
        found = self.design.friction
        assert found is not None
        return found

    def report(self, variant: str) -> CharacterisationReport | None:
        """The tables of a resonator; None: it was not measured."""
        found = self.outcomes.get(variant)
        return None if found is None else found.report


def mean_of(found: ShotStatistics | None, factor: float) -> Value | None:
    """With its standard error."""
    if found is None:
        return None
    return Value(found.mean * factor, None if found.std is None else found.std * factor / math.sqrt(found.shots))


def scatter_of(found: ShotStatistics | None, factor: float) -> Value | None:
    """Standard deviation from shot to shot, with the standard error that normal values give it."""
    if found is None or found.std is None:
        return None
    return Value(found.std * factor, found.std * factor / math.sqrt(2.0 * (found.shots - 1)))


def median_of(found: ShotStatistics | None, factor: float) -> Value | None:
    """With the standard error that normal values give it."""
    if found is None:
        return None
    u = None if found.std is None else math.sqrt(math.pi / 2.0) * found.std * factor / math.sqrt(found.shots)
    return Value(found.median * factor, u)


def lowest_of(found: ShotStatistics | None, factor: float) -> Value | None:
    """The smallest value."""
    return None if found is None else Value(found.lowest * factor)
