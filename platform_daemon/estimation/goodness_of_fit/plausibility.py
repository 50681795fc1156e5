"""Doubts about results that no resonator has: a number of the record was in another unit than it seemed."""

from __future__ import annotations

from collections.abc import Mapping

from platform_daemon.estimation.record import Quantity
from platform_daemon.estimation.result import Estimate
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.goodness_of_fit


def plausibility_warnings(quantity: Quantity, parameters: Mapping[str, Estimate]) -> tuple[str, ...]:
    """A warning for each of f_nat and m_r that was estimated far outside of what resonators have.

    A wrong unit of the clock or of the sensitivity scales these two as a whole, and the fit is as good as ever.
    """
    ranges = {
        "f_nat_hz": (LIMITS.plausible_angle_hz if quantity == "angle" else LIMITS.plausible_f_nat_hz, "Hz"),
        "m_r_am2": (LIMITS.plausible_m_r_am2, "A m²"),
    }
    causes = {
        "f_nat_hz": "the unit of the time column"
        if quantity == "angle"
        else "the unit of the time, or of baseFrequency, and the decimation",
        "m_r_am2": "the units of the sensitivity and of the volts",
    }
    return tuple(
        f"implausible: {name.partition('_h')[0].removesuffix('_am2')} is {found.value:.4g} {unit}, outside of "
        f"{low:g} to {high:g} {unit}; check {causes[name]}"
        for name, ((low, high), unit) in ranges.items()
        if (found := parameters.get(name)) is not None and found.std is not None and not low <= found.value <= high
    )
