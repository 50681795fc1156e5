"""What follows from the fits of a series: quality factors, envelopes, orientation errors, Allan deviation.

Everything is computed from a report in the fixed JSON form (fit.py), so that it holds for stored results too.
Keys carry units; a quantity that this series cannot give is null, and `notes` say why.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from datetime import datetime
from typing import Any

import numpy as np

from platform_daemon.estimation import (
    RODRIGUES,
    Envelopes,
    RingDown,
    RingDownModel,
    envelopes,
    equivalent_quality_factor,
    quality_factor,
)
from platform_daemon.store import Recording

from .series.allan import AllanDeviation, allan_deviation
from .series.orientation import OrientationSpread, best_orientation, orientation_spread


def frame_quantities(variant: str | RingDownModel, frame: Mapping[str, Any]) -> dict[str, float | None]:
    """Q of the viscous losses alone, and the equivalent Q over the window and to infinity, of one good frame."""
    if frame["verdict"] != "good":
        return {}
    p = _values(frame)
    ring_down = RingDown.from_parameters(variant, p)
    return {
        "quality_factor": quality_factor(p["f_nat_hz"], p["lambda_per_s"]) if p.get("lambda_per_s", 0.0) > 0 else None,
        "equivalent_quality_factor": _equivalent(ring_down, frame["window_s"]),
        "equivalent_quality_factor_to_infinity": _equivalent(ring_down, math.inf),
    }


def series_quantities(report: Mapping[str, Any], times_s: list[float | None]) -> dict[str, Any]:
    """Orientation errors against mean and best, and the Allan deviation of f_nat, over the frames of a report.

    times_s: of every frame, from any zero; None where the file does not say.
    """
    good = [f for f in report["frames"] if f["verdict"] == "good"]
    notes: list[str] = []
    turned = [f for f in good if RODRIGUES[0] in f["parameters"]]
    if len(turned) < 2:
        # The one frame is its own reference: an error of zero would say nothing.
        notes.append(f"orientation: {len(turned)} good frames with a calibration; an error needs two")
    return {
        "orientation_error": _orientation_errors(turned) if len(turned) > 1 else None,
        "allan_deviation": _allan(good, [times_s[f["frame"]] for f in good], notes),
        "notes": notes,
    }


def frame_envelopes(variant: str | RingDownModel, frame: Mapping[str, Any], points: int) -> dict[str, list[float]]:
    """Envelopes of v and u, A(t) and f(t) - f_nat over the window of a good frame.  Raises ValueError without m_r."""
    found: Envelopes = envelopes(RingDown.from_parameters(variant, _values(frame)), frame["window_s"], points)
    return {
        "t_s": found.time_s.tolist(),
        "amplitude_rad": found.amplitude_rad.tolist(),
        "v_am2_per_s": found.v_am2_per_s.tolist(),
        "u_am2_per_s": found.u_am2_per_s.tolist(),
        "frequency_minus_f_nat_hz": found.frequency_shift_hz.tolist(),
    }


def frame_times_s(recording: Recording) -> list[float | None]:
    """When each frame was triggered, s from any zero: by the host's monotonic clock, else by the time stamps."""
    monotonic = [info.monotonic_s for info in recording.frame_info]
    if all(t is not None and math.isfinite(t) for t in monotonic):
        return monotonic
    return [_stamp(info.time_stamp) for info in recording.frame_info]


def _stamp(text: str | None) -> float | None:
    try:
        return None if not text else datetime.fromisoformat(text).timestamp()
    except ValueError:
        return None


def _values(frame: Mapping[str, Any]) -> dict[str, float]:
    return {name: estimate["value"] for name, estimate in frame["parameters"].items()}


def _equivalent(ring_down: RingDown, duration_s: float) -> float | None:
    try:
        return equivalent_quality_factor(ring_down, duration_s)
    except (ValueError, ArithmeticError):  # a motion that does not decay has none
        return None


def _orientation_errors(frames: list[Mapping[str, Any]]) -> dict[str, Any]:
    vectors = np.array([[f["parameters"][n]["value"] for n in RODRIGUES] for f in frames])
    best = best_orientation(vectors, np.array([f["r2"] for f in frames]))
    spreads = {"mean": orientation_spread(vectors), "best": orientation_spread(vectors, best)}
    return {"frames": [f["frame"] for f in frames], **{f"against_{k}": _spread(s) for k, s in spreads.items()}}


def _spread(spread: OrientationSpread) -> dict[str, Any]:
    return {
        "reference_rodrigues_rad": spread.reference.tolist(),
        "angle_rad": spread.angle_rad.tolist(),
        "mean_rad": spread.mean_rad,
        "std_rad": spread.sd_rad if math.isfinite(spread.sd_rad) else None,
    }


def _allan(frames: list[Mapping[str, Any]], times_s: list[float | None], notes: list[str]) -> dict[str, Any] | None:
    known = [t for t in times_s if t is not None]
    if len(known) < len(times_s):
        notes.append("allan_deviation: the file does not say when its frames were taken")
        return None
    frequencies = np.array([f["parameters"]["f_nat_hz"]["value"] for f in frames])
    try:
        found: AllanDeviation = allan_deviation(np.array(known), frequencies)
    except ValueError as error:
        notes.append(f"allan_deviation: {error}")
        return None
    return {
        "tau_s": found.tau_s.tolist(),
        "deviation_hz": found.deviation_hz.tolist(),
        "low_hz": found.low_hz.tolist(),
        "high_hz": found.high_hz.tolist(),
        "noise": list(found.noise),
        "slope": found.slope if math.isfinite(found.slope) else None,
        "slope_std": found.slope_sd if math.isfinite(found.slope_sd) else None,
        "mean_hz": found.mean_hz,
        "cadence_s": found.cadence_s,
    }
