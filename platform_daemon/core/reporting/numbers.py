"""Numbers with their errors, and the parameters of a resonator in the unit that people read."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Protocol

from platform_daemon.core.schemas.parameters import ParameterDefinition, definition_of


class _Estimate(Protocol):
    @property
    def value(self) -> float:
        """In SI."""

    @property
    def std(self) -> float | None:
        """Its standard deviation, SI; None: it was held."""


def number(value: float | None, std: float | None, factor: float = 1.0) -> str:
    """Value with its standard deviation in brackets at the last digits: 215.6903(12); plain if there is none."""
    if value is None:
        return "-"
    if std is None or not std > 0:
        return f"{value * factor:.6g}"
    digits = max(0, 1 - math.floor(math.log10(std * factor)))
    return f"{value * factor:.{digits}f}({round(std * factor * 10**digits)})"


def spread(mean: float, std: float | None, factor: float = 1.0) -> str:
    """Mean with the scatter around it, to the scatter's second digit: 213.165 ± 0.079; plain if there is none."""
    if std is None or not std > 0:
        return f"{mean * factor:.6g}"
    digits = max(0, 1 - math.floor(math.log10(std * factor)))
    return f"{mean * factor:.{digits}f} ± {std * factor:.{digits}f}"


def in_words(definition: ParameterDefinition, value: float, std: float | None) -> str:
    """As in: m_r 4.321(12) mAm²."""
    return f"{definition.symbol} {number(value, std, definition.display_factor)} {definition.display_unit}".rstrip()


def estimates_text(parameters: Mapping[str, _Estimate]) -> str:
    """Estimates in one line, without the orientation."""
    named = [(name, e) for name, e in parameters.items() if not name.startswith("rodrigues")]
    return ", ".join(in_words(definition_of(name), e.value, e.std) for name, e in named)
