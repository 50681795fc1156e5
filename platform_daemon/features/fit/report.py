"""Fits for the terminal: a row per frame, in as many tables below each other as the terminal's width takes."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import Any

from platform_daemon.core.reporting.numbers import in_words, number
from platform_daemon.core.reporting.tables import Column, tables_text
from platform_daemon.core.schemas.derived import FrameQuantities, OrientationDeviation, SeriesQuantities
from platform_daemon.core.schemas.fits import BLANK, FitReport, FrameFit
from platform_daemon.core.schemas.parameters import PARAMETERS, RODRIGUES, definition_of, names_in_order
from platform_daemon.core.schemas.value_sources import value_sources_text

from .prediction_schema import PredictionReport

MOMENT = "m_r_am2"
_IN_A_LINE = ("f_nat_hz", MOMENT, "lambda_per_s", "tf_over_i_rad_per_s2")
_DEFAULT = (*_IN_A_LINE, "phi_max_rad", "psi_start_rad")  # of a report without a good frame
_NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w])")


def fit_table_text(report: FitReport) -> str:
    """One file's fits: a row per frame, then mean and scatter, what was derived, and what is to be said of them."""
    means = any(s.std is not None for s in report.summary.values())
    rows = [str(f.frame) for f in report.frames] + ["mean(scatter)"] * means
    title = f"{report.file}  {report.variant}, window {str(report.window).upper()}"
    return "\n".join([tables_text(title, ("frame", rows), _columns(report, means=means), means), *_notes(report)])


def fit_rows(report: FitReport) -> list[dict[str, Any]]:
    """For a CSV: a row per frame, with file, model and window; the covariance is in `--json` only."""
    of_file = {"file": report.file, "variant": report.variant, "window": report.window}
    return [of_file | frame.model_dump(exclude={"covariance"}) for frame in report.frames]


def _columns(report: FitReport, *, means: bool) -> list[Column]:
    """What was fitted, the orientation, how good it is, and the quality factors if they were requested."""
    names = [n for n in report.summary or _DEFAULT if n not in RODRIGUES]
    columns = [_parameter(report, name, means=means) for name in names]
    if RODRIGUES[0] in report.summary:
        cells = [_rodrigues(f.values) if f.good else "" for f in report.frames]
        means_of = {name: s.mean for name, s in report.summary.items()}
        columns.append(("R / rad", cells + [_rodrigues(means_of)] * means))
    for heading, quality in (
        ("R² / %", lambda f: f"{100 * f.r2:.4f}"),
        ("nRMSE / %", lambda f: f"{100 * f.nrmse:.3f}"),
        ("χ²/dof", lambda f: f"{f.chi2_per_dof:.3f}"),
    ):
        columns.append((heading, [quality(f) if f.good else "" for f in report.frames] + [""] * means))
    quantities = [f.derived if isinstance(f.derived, FrameQuantities) else None for f in report.frames]
    if any(quantities):
        for heading, key in (
            ("Q", "quality_factor"),
            ("Q_eq", "equivalent_quality_factor"),
            ("Q_eq to ∞", "equivalent_quality_factor_to_infinity"),
        ):
            cells = ["" if q is None else _rounded(getattr(q, key)) for q in quantities]
            columns.append((heading, cells + [""] * means))
    return columns


def _rounded(value: float | None) -> str:
    return "-" if value is None else f"{value:.5g}"


def _parameter(report: FitReport, name: str, *, means: bool) -> Column:
    shown, first = definition_of(name), name == next(iter(report.summary), _DEFAULT[0])
    cells = []
    for frame in report.frames:
        estimate = frame.parameters.get(name)
        missing = "-" if frame.good else "" if not first else "blank" if frame.blank else "refused"
        cells.append(missing if estimate is None else number(estimate.value, estimate.std, shown.display_factor))
    if means:
        cells.append(number(report.summary[name].mean, report.summary[name].std, shown.display_factor))
    return shown.heading, cells


def _rodrigues(values: dict[str, float]) -> str:
    return "(" + ", ".join(f"{values[name]:.4f}" for name in RODRIGUES) + ")" if RODRIGUES[0] in values else "-"


def fit_line(report: FitReport) -> str:
    """One file's fits in one line: how many, and the mean with the scatter of the parameters."""
    summaries = [(PARAMETERS[name], report.summary[name]) for name in _IN_A_LINE if name in report.summary]
    blank = len(report.blank_frames)
    good = f"{len(report.good_frames)} of {len(report.frames) - blank} frames good"
    good += f" and {blank} blank" if blank else ""
    return ", ".join([good, *(in_words(shown, s.mean, s.std) for shown, s in summaries)])


def _notes(report: FitReport) -> list[str]:
    """Notes of the file and of its frames, each once with the frames that it holds for."""
    lines = [f"note: {n}" for n in report.notes]
    if MOMENT in report.systematic_std:
        std = 1e3 * report.systematic_std[MOMENT]
        lines.append(f"m_r has a systematic standard uncertainty of {std:.2g} mAm² besides, from the calibration")
    if report.noise.source is not None:
        lines.append(f"noise from {report.noise.source}; measuring it took {report.noise.seconds:.3f} s")
    lines += _series_lines(report.derived) + frame_notes(report.frames)
    return [*lines, value_sources_text(report.value_sources)] if report.value_sources else lines


def frame_notes(frames: Iterable[FrameFit]) -> list[str]:
    """Each text once with its frames; of texts that differ in their numbers only, that of the first frame."""
    said: dict[str, dict[int, str]] = {}
    for frame in frames:
        refused = () if frame.good else (BLANK,) if frame.blank else (f"refused: {frame.reason}",)
        for text in (*frame.notes, *frame.warnings, *refused):
            said.setdefault(_NUMBER.sub("#", text), {})[frame.frame] = text
    lines = []
    for texts in said.values():
        first, text = next(iter(texts.items()))
        differ = f" (numbers of frame {first})" if len(set(texts.values())) > 1 else ""
        lines.append(f"frame {ranges(texts)}: {text}{differ}")
    return lines


def ranges(numbers: Iterable[int]) -> str:
    """As in: 0-4, 7, 9."""
    runs: list[list[int]] = []
    for k in numbers:
        if runs and k == runs[-1][-1] + 1:
            runs[-1].append(k)
        else:
            runs.append([k])
    return ", ".join(str(r[0]) if len(r) == 1 else f"{r[0]}-{r[-1]}" for r in runs)


def _series_lines(derived: SeriesQuantities | None) -> list[str]:
    """Orientation errors and Allan deviation in words."""
    if derived is None:
        return []
    lines = list(derived.notes)
    if derived.orientation_error is not None:
        against = derived.orientation_error
        text = f"mean orientation {_angle(against.against_mean)}, the best {_angle(against.against_best)}"
        lines.append(f"orientation error against the {text}")
    allan = derived.allan_deviation
    if allan is not None:
        text = ", ".join(f"{d:.3g} Hz at {t:.4g} s" for d, t in zip(allan.deviation_hz, allan.tau_s, strict=True))
        slope = "" if allan.slope is None else f"; slope {number(allan.slope, allan.slope_std)}"
        lines.append(f"Allan deviation of f_nat: {text}{slope}")
    return lines


def _angle(found: OrientationDeviation) -> str:
    mean, std = math.degrees(found.mean_rad), found.std_rad
    return f"{mean:.3g}°" + ("" if std is None else f" (scatter {math.degrees(std):.2g}°)")


def prediction_table_text(found: PredictionReport) -> str:
    """The smallest standard deviations of a plan, a row per window."""
    names = [n for n in found.expected if n not in RODRIGUES]
    index = ("window / s", [f"{row.window_s:.3f}" for row in found.windows])
    columns: list[Column] = []
    for shown in map(definition_of, names_in_order(set(names))):
        stds = [row.std.get(shown.name) for row in found.windows]
        columns.append((shown.heading, ["-" if s is None else f"{s * shown.display_factor:.2g}" for s in stds]))
    columns.append(("orientation / °", [f"{math.degrees(row.orientation_rad):.2g}" for row in found.windows]))
    table = tables_text(f"{found.variant}: smallest standard deviations", index, columns)
    return "\n".join([table, *(f"note: {text}" for text in found.notes or ())])
