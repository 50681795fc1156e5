"""An analysis of one's own: how fast a resonator loses its energy."""

from __future__ import annotations

import math

import platform_daemon as pd_


def quality_factor(recording: pd_.Recording) -> float:
    """Quality factor of the viscous damping, from a fit of the first usable frame."""
    fit = pd_.fit(recording, window="d30")
    return math.pi * fit["f_nat_hz"].value / fit["lambda_per_s"].value
