"""What follows from the fits of a series: quality factors, envelopes, orientation errors, Allan deviation.

Everything is computed from reports, so that it holds for stored results too.  A quantity that this series cannot give
is None, and `notes` say why.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from platform_daemon.core.schemas.base import NoResult
from platform_daemon.core.schemas.derived import (
    AllanReport,
    DerivedReport,
    EnvelopesReport,
    FittedFrameQuantities,
    FrameQuantities,
    OrientationErrors,
    SeriesQuantities,
    UnfittedFrameQuantities,
)
from platform_daemon.core.schemas.fits import FrameFit
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.parameters import RODRIGUES
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.quality import envelopes, equivalent_quality_factor, quality_factor
from platform_daemon.estimation.physics.ring_down import RingDown

from .series.allan import allan_deviation
from .series.orientation import best_orientation, orientation_spread

Model = str | RingDownModel


def derived_report(model: Model, frames: Sequence[FrameFit], times_s: Sequence[float | None]) -> DerivedReport:
    """Of every frame and of the series; times_s: see series_quantities."""
    by_frame = [(frame.frame, frame_quantities(model, frame)) for frame in frames]
    return DerivedReport(
        frames=tuple(
            UnfittedFrameQuantities(frame=k) if isinstance(q, NoResult) else FittedFrameQuantities(frame=k, **dict(q))
            for k, q in by_frame
        ),
        **dict(series_quantities(frames, times_s)),
    )


def frame_quantities(model: Model, frame: FrameFit) -> FrameQuantities | NoResult:
    """Q of the viscous losses alone, and the equivalent Q over the window and to infinity, of one good frame."""
    if frame.window_s is None or not frame.good:
        return NoResult()
    p = frame.values
    ring_down = RingDown.from_parameters(model, p)
    return FrameQuantities(
        quality_factor=quality_factor(p["f_nat_hz"], p["lambda_per_s"]) if p.get("lambda_per_s", 0.0) > 0 else None,
        equivalent_quality_factor=_equivalent(ring_down, frame.window_s),
        equivalent_quality_factor_to_infinity=_equivalent(ring_down, math.inf),
    )


def series_quantities(frames: Sequence[FrameFit], times_s: Sequence[float | None]) -> SeriesQuantities:
    """Orientation errors against mean and best, and the Allan deviation of f_nat, over the frames of a report.

    times_s: of every frame of the file, from any zero; None where the file does not say.
    """
    good = [frame for frame in frames if frame.good]
    notes: list[str] = []
    turned = [frame for frame in good if RODRIGUES[0] in frame.parameters]
    if len(turned) < 2:
        # The one frame is its own reference: an error of zero would say nothing.
        notes.append(f"orientation: {len(turned)} good frames with a calibration; an error needs two")
    return SeriesQuantities(
        orientation_error=_orientation_errors(turned) if len(turned) > 1 else None,
        allan_deviation=_allan(good, [times_s[frame.frame] for frame in good], notes),
        notes=tuple(notes),
    )


def frame_envelopes(model: Model, frame: FrameFit, points: int, duration_s: float | None = None) -> EnvelopesReport:
    """Envelopes of v and u, A(t) and f(t) - f_nat of a good frame over its window, or so long.

    Raises ValueError without m_r.
    """
    if frame.window_s is None:
        raise ValueError("a refused frame has no envelopes")
    found = envelopes(RingDown.from_parameters(model, frame.values), duration_s or frame.window_s, points)
    return EnvelopesReport(
        frame=frame.frame,
        t_s=_listed(found.time_s),
        amplitude_rad=_listed(found.amplitude_rad),
        v_am2_per_s=_listed(found.v_am2_per_s),
        u_am2_per_s=_listed(found.u_am2_per_s),
        frequency_minus_f_nat_hz=_listed(found.frequency_shift_hz),
    )


def _listed(values: Array) -> tuple[float, ...]:
    return tuple(values.tolist())


def _equivalent(ring_down: RingDown, duration_s: float) -> float | None:
    try:
        return equivalent_quality_factor(ring_down, duration_s)
    except (ValueError, ArithmeticError):  # a motion that does not decay has none
        return None


def _orientation_errors(frames: Sequence[FrameFit]) -> OrientationErrors:
    vectors = np.array([[frame.values[name] for name in RODRIGUES] for frame in frames])
    best = best_orientation(vectors, np.array([frame.r2 for frame in frames], dtype=float))
    return OrientationErrors(
        frames=tuple(frame.frame for frame in frames),
        against_mean=orientation_spread(vectors),
        against_best=orientation_spread(vectors, best),
    )


def _allan(frames: Sequence[FrameFit], times_s: list[float | None], notes: list[str]) -> AllanReport | None:
    known = [t for t in times_s if t is not None]
    if len(known) < len(times_s):
        notes.append("allan_deviation: the file does not say when its frames were taken")
        return None
    try:
        return allan_deviation(np.array(known), np.array([frame.values["f_nat_hz"] for frame in frames]))
    except ValueError as error:
        notes.append(f"allan_deviation: {error}")
        return None
