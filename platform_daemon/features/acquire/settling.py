"""Does the resonator come to rest before the next shot?  A bound from the expected damping, before hardware moves."""

from __future__ import annotations

import math
from dataclasses import dataclass

from drivers.specimen import Specimen
from platform_daemon.core.hardware.catalogue import Damping
from platform_daemon.design.equations import expected_inertia, expected_moment, expected_omega
from sequences.compiler import ShotPlan


@dataclass(frozen=True)
class Settling:
    """Deflection right after TX (upper bound) and right before the next TX, rad; `share` of the one in the other."""

    start_rad: float
    remaining_rad: float
    share: float
    warning: str | None


def deflection_bound(plan: ShotPlan, specimen: Specimen) -> float:
    """Deflection after TX if every period pushed in phase (linear, lossless), at most 90 deg; rad.

    The fundamental of a rectangle is up to 4/pi of its height.
    """
    drive = expected_moment(specimen) / expected_inertia(specimen) * (0.0 if plan.blank else plan.request.field_t)
    tx_s = plan.timeline.tx_samples / plan.timeline.clock.rate_hz
    drive *= 4 / math.pi if plan.request.waveform == "rectangle" else 1.0
    return min(drive * tx_s / (2 * expected_omega(specimen)), math.pi / 2)


def remaining_amplitude(start_rad: float, lambda_per_s: float, tf_over_i: float, omega: float, time_s: float) -> float:
    """Amplitude after `time_s` under viscous and dry friction, rad.

    Averaged over a period, dA/dt = -lambda A - (2/pi) (T_f/I)/omega (small angles); zero once friction has won.
    """
    friction = 2 * tf_over_i / (math.pi * omega)
    if lambda_per_s == 0:
        return max(0.0, start_rad - friction * time_s)
    decay = math.exp(-lambda_per_s * time_s)
    return max(0.0, start_rad * decay - friction / lambda_per_s * (1 - decay))


def time_until(start_rad: float, end_rad: float, lambda_per_s: float, tf_over_i: float, omega: float) -> float:
    """When the amplitude has fallen from `start_rad` to `end_rad`, s: the inverse of `remaining_amplitude`; 0 if it is
    below already, infinite without any friction."""
    friction = 2 * tf_over_i / (math.pi * omega)
    if end_rad >= start_rad:
        return 0.0
    if lambda_per_s == 0:
        return (start_rad - end_rad) / friction if friction > 0 else math.inf
    rest = friction / lambda_per_s
    return math.log((start_rad + rest) / (end_rad + rest)) / lambda_per_s if end_rad + rest > 0 else math.inf


def settling(plan: ShotPlan, specimen: Specimen, threshold: float, tuned: Damping | None = None) -> Settling:
    """The settle check of a series with this plan; `warning` is set if more than `threshold` remains.

    tuned: the damping that a tune has found, which counts more than that of the declaration; None: there is none.
    Damping that nobody has measured counts as none, so that the check never promises too much.
    """
    rest_s = plan.timeline.duration_s - plan.timeline.tx_samples / plan.timeline.clock.rate_hz + plan.request.pause_s
    start = deflection_bound(plan, specimen)
    m = specimen.measured
    damping = tuned or Damping(m.lambda_per_s or 0.0, m.tf_over_i_rad_per_s2 or 0.0)
    remaining = remaining_amplitude(
        start, damping.lambda_per_s, damping.tf_over_i_rad_per_s2, expected_omega(specimen), rest_s
    )
    share = remaining / start if start > 0 else 0.0
    warning = None
    if share > threshold and tuned is None and m.lambda_per_s is None:
        warning = (
            f"not_settled: the damping of {specimen.name} has not been measured, so that up to {share:.1%} of "
            "the deflection may remain at the next shot; run tune, or give lambda_per_s in [measured]"
        )
    elif share > threshold:
        warning = (
            f"not_settled: about {share:.1%} of the deflection ({math.degrees(remaining):.2f} deg) remains at the next "
            f"shot, more than {threshold:.0%}; lengthen rx_s or pause_s"
        )
    return Settling(start, remaining, share, warning)
