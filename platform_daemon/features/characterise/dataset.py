"""The fits of one window as a row of the paper's tables, and the orientations that both windows are compared by."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from statistics import median

import numpy as np

from platform_daemon.core.schemas.base import NamedWindow
from platform_daemon.core.schemas.fits import FitReport, FrameFit
from platform_daemon.core.schemas.parameters import names_in_order
from platform_daemon.estimation.parameters import RODRIGUES
from platform_daemon.estimation.physics.mirror import on_one_branch
from platform_daemon.features.fit.series.orientation import error_angle

from .schema import FitDataset, OrientationReference, ParameterStatistics, RefusedShots, ShotStatistics
from .statistics import statistics_of

PHASE = "psi_start_rad"
"""The parameter of which 0 and 2 pi are the same."""


@dataclass(frozen=True)
class ShotValues:
    """The good fits of one window: parameters by frame, every shot by the same of its two mirror solutions, and angles
    to the orientation of reference, rad, by frame."""

    parameters: Mapping[int, Mapping[str, float]]
    errors_rad: Mapping[int, float]


def orientation_reference(d30: FitReport) -> OrientationReference | None:
    """The D30 fit with the largest R² (ssec:primary_results); None if no good one has an orientation."""
    turned = [(f.r2, f) for f in d30.good_frames if RODRIGUES[0] in f.parameters and f.r2 is not None]
    if not turned:
        return None
    r2, best = max(turned, key=lambda one: one[0])
    return OrientationReference(frame=best.frame, r2=r2, rodrigues_rad=tuple(best.values[n] for n in RODRIGUES))


def shot_values(reports: Iterable[FitReport], reference: OrientationReference | None) -> list[ShotValues]:
    """Of each report; the mirror solutions are chosen over all of them together."""
    all_reports = list(reports)
    folded = iter(on_one_branch([frame.values for report in all_reports for frame in report.good_frames])[0])
    found = []
    for report in all_reports:
        rows = {frame.frame: next(folded) for frame in report.good_frames}
        turned = {k: [row[name] for name in RODRIGUES] for k, row in rows.items() if RODRIGUES[0] in row}
        errors: dict[int, float] = {}
        if reference is not None and turned:
            angles = error_angle(np.array(list(turned.values())), np.array(reference.rodrigues_rad))
            errors = dict(zip(turned, angles.tolist(), strict=True))
        found.append(ShotValues(rows, errors))
    return found


def dataset_of(window: NamedWindow, report: FitReport, values: ShotValues, held: Mapping[str, float]) -> FitDataset:
    """The row of one window."""
    good = report.good_frames

    def over(pick: Iterable[float | None]) -> ShotStatistics | None:
        return statistics_of(pick)

    return FitDataset(
        window=window,
        shots=len(report.frames),
        good=len(good),
        refused=_refused(report.frames),
        held=dict(held),
        duration_s=over(f.window_s for f in good),
        r2=over(f.r2 for f in good),
        nrmse=over(f.nrmse for f in good),
        chi2_per_dof=over(f.chi2_per_dof for f in good),
        computing_s=over(f.seconds for f in good),
        parameters=_parameters(report, values),
        orientation_error_rad=over(values.errors_rad.values()),
    )


def _refused(frames: Iterable[FrameFit]) -> tuple[RefusedShots, ...]:
    """By reason: by its code where it begins with one, for the numbers behind it differ from shot to shot."""
    found: dict[str, list[FrameFit]] = {}
    for frame in frames:
        if not frame.good:
            found.setdefault((frame.reason or "").partition(":")[0], []).append(frame)
    return tuple(
        RefusedShots(reason=alike[0].reason or "", frames=tuple(frame.frame for frame in alike))
        for alike in found.values()
    )


def _parameters(report: FitReport, values: ShotValues) -> dict[str, ParameterStatistics]:
    rows = list(values.parameters.values())
    found = {}
    for name in names_in_order({name for row in rows for name in row} - set(RODRIGUES)):
        over = statistics_of((row.get(name) for row in rows), circular=name == PHASE)
        stds = [f.parameters[name].std for f in report.good_frames if name in f.parameters]
        known = [std for std in stds if std is not None]
        if over is not None:
            found[name] = ParameterStatistics(
                **dict(over),
                fit_std=median(known) if known else None,
                systematic_std=report.systematic_std.get(name),
            )
    return found
