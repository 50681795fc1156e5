"""What is missing in a characterisation and why, and what may spoil its numbers, in words."""

from __future__ import annotations

import math
from collections.abc import Iterator

from platform_daemon.core.schemas.parameters import definition_of
from platform_daemon.core.schemas.recordings import RecordingInfo

from .schema import CharacterisationReport

_WHOLE = 0.999  # of the receive window
_FAR = 3.0  # standard deviations of the correlation of independent shots


def notes_of(report: CharacterisationReport, held_by_request: bool, info: RecordingInfo) -> Iterator[str]:
    """Line by line."""
    yield from report.d30_fits.notes
    yield from _of_shots(report)
    yield from _of_excitation(report, info)
    yield from _of_held(report, held_by_request)
    yield from _of_orientation(report)
    yield from _of_windows(report)
    yield from _of_dependence(report)


def _of_shots(report: CharacterisationReport) -> Iterator[str]:
    for name, dataset in (("N50", report.n50), ("D30", report.d30)):
        for refused in dataset.refused:
            yield f"{name}: {len(refused.frames)} of {dataset.shots} shots refused: {refused.reason}"
        if dataset.good == 1:
            yield f"{name}: one good shot has no scatter"
        elif not dataset.good:
            yield f"{name}: no good shot, all its entries are empty"


def _of_excitation(report: CharacterisationReport, info: RecordingInfo) -> Iterator[str]:
    frames = {frame.frame for frame in report.d30_fits.frames}
    made = [shot.excitation for shot in info.shots if shot.frame in frames and shot.excitation is not None]
    different = {(e.field_t, e.axis, e.periods, e.requested_hz) for e in made}
    if len(different) > 1:
        low, high = (1e6 * f(e.field_t for e in made) for f in (min, max))
        yield (
            f"the shots were excited in {len(different)} different ways ({low:.4g} to {high:.4g} µT): means and "
            "scatters mix them; choose the frames of one of them"
        )


def _of_held(report: CharacterisationReport, held_by_request: bool) -> Iterator[str]:
    for name, value in report.n50.held.items():
        shown = definition_of(name)
        source = "as requested" if held_by_request else "the median of the D30 fits"
        yield (
            f"N50 holds {shown.symbol} at {value:.4g} {shown.display_unit}, {source}: so short a window cannot tell "
            "two losses apart (tab:model_fit_params); what it finds for the other one depends on that"
        )


def _of_orientation(report: CharacterisationReport) -> Iterator[str]:
    reference = report.orientation_reference
    if reference is None:
        yield "orientation: no good D30 fit with a calibration, so there is no reference to measure errors from"
    elif report.d30.good == 1:
        yield f"orientation: frame {reference.frame}, the one good D30 fit, is its own reference: its error is 0"
    else:
        yield (
            f"orientation: frame {reference.frame} is the reference; its own D30 error of 0 is in the mean, as in the "
            "paper, but not in the comparison"
        )


def _of_windows(report: CharacterisationReport) -> Iterator[str]:
    short, long = report.n50.duration_s, report.d30.duration_s
    cut = [f.frame for f in report.d30_fits.good_frames if (f.window_s or 0.0) > _WHOLE * report.receive_s]
    if cut:
        yield (
            f"D30: in {len(cut)} of {report.d30.good} shots more than 30 % are left at the end of the receive window "
            f"of {report.receive_s:.3g} s: there D30 is that window"
        )
    if short is not None and long is not None and long.lowest < short.median:
        yield f"D30 ends after {long.lowest:.3g} s in at least one shot, before N50: there the two are hardly apart"


def _of_dependence(report: CharacterisationReport) -> Iterator[str]:
    for row in report.comparisons:
        if row.significant and (row.signed_rank_p_value or 0.0) > report.alpha:
            yield f"{row.quantity}: significant by the t test, but not by signed ranks: a few shots make the difference"
        r = row.lag_one_correlation
        if r is not None and r * math.sqrt(row.shots) > _FAR:
            yield (
                f"{row.quantity}: the difference of a shot goes with that of the shot before (correlation {r:.2f}); "
                "shots are no independent draws, and its p value is too small"
            )
