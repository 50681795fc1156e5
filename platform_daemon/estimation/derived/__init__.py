"""Quantities derived from fits: pure functions, fit results and arrays in, frozen dataclasses out.

ring_down         the known motion that everything here starts from
quality           Q, equivalent quality factor, envelopes, frequency trace
orientation       error angles over a series
twins             phi -> -phi: the motion that gives the same signal
"""

from __future__ import annotations

from .allan import AllanDeviation, allan_deviation
from .frequency_domain import (
    BiasAgainstFit,
    FrequencyDomainEstimate,
    bias_against_fit,
    estimate_from_harmonics,
)
from .orientation import (
    OrientationSpread,
    best_orientation,
    error_angle,
    mean_orientation,
    orientation_spread,
    orientations,
)
from .predict import Plan, Precision, planned_window_s, precision_table, predict_precision
from .quality import (
    Envelopes,
    decay_time_s,
    envelopes,
    equivalent_quality_factor,
    quality_factor,
    small_angle_quality_factor,
)
from .ring_down import RingDown
from .twins import RODRIGUES, on_one_side

__all__ = [
    "RODRIGUES",
    "AllanDeviation",
    "BiasAgainstFit",
    "Envelopes",
    "FrequencyDomainEstimate",
    "OrientationSpread",
    "Plan",
    "Precision",
    "RingDown",
    "allan_deviation",
    "best_orientation",
    "bias_against_fit",
    "decay_time_s",
    "envelopes",
    "equivalent_quality_factor",
    "error_angle",
    "estimate_from_harmonics",
    "mean_orientation",
    "on_one_side",
    "orientation_spread",
    "orientations",
    "planned_window_s",
    "precision_table",
    "predict_precision",
    "quality_factor",
    "small_angle_quality_factor",
]
