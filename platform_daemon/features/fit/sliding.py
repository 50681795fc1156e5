"""Sliding-window fits of a stored frame: the report, and what to draw of it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict

from drivers.errors import InputError
from platform_daemon.core.schemas.fits import ParameterEstimate
from platform_daemon.estimation.sliding_window import (
    LambdaMode,
    ReferenceRefusedError,
    SlidingBounds,
    SlidingFit,
    WindowFit,
    fit_sliding,
)
from platform_daemon.features.models.resolve import ModelChoice, model_of

from .fit import covariance_of
from .fit_request import FitRefused
from .measurement import Measurement
from .sliding_schema import FlatnessReport, SlidingReport, WindowFitReport


def slide_frame(
    measurement: Measurement,
    frame: int,
    model: ModelChoice | None,
    window_s: float | None,
    step_s: float | None,
    lambda_mode: LambdaMode = "auto",
    *,
    terms: Sequence[str] = (),
    options: tuple[str, str] = ("window_s", "step_s"),
    bounds: SlidingBounds | None = None,
) -> SlidingFit:
    """Fit a frame window by window; options: what the caller calls the two lengths; bounds: how much it may be.

    Raises InputError for lengths that do not fit, FitRefused if they cannot be chosen, and what reading it raises.
    """
    measurement, chosen = measurement.under(model, terms)
    record = measurement.signal(frame).record
    noise = measurement.noise().for_shot(record).model
    model_used = model_of(chosen).under_weight(measurement.weight_over_pull())
    with _said_of(f"frame {frame}", options):
        return fit_sliding(record, model_used, window_s, step_s, lambda_mode=lambda_mode, noise=noise, bounds=bounds)


@contextmanager
def _said_of(where: str, options: tuple[str, str]) -> Iterator[None]:
    """Lengths that do not fit, or cannot be chosen, as errors of the caller."""
    try:
        yield
    except ReferenceRefusedError as refused:
        remedy = f"give the length of the windows with {options[0]}, in seconds"
        raise FitRefused("no windows", where=where, why=str(refused), remedy=remedy) from None
    except ValueError as error:
        remedy = f"give other lengths with {' and '.join(options)}, in seconds"
        raise InputError("no windows", where=where, why=str(error), remedy=remedy) from None


def sliding_report(found: SlidingFit) -> SlidingReport:
    """Every window with its estimates or the reason of its refusal, and how flat each constant is."""
    flat = {name: found.flatness(name) for name in found.constants}
    return SlidingReport(
        window_s=found.window_s,
        step_s=found.step_s,
        windows=tuple(_window(w) for w in found.windows),
        flatness={name: FlatnessReport(**asdict(f)) for name, f in flat.items() if f is not None},
    )


def _window(window: WindowFit) -> WindowFitReport:
    fit = window.fit
    return WindowFitReport(
        start_s=window.start_s,
        end_s=window.end_s,
        centre_s=window.centre_s,
        verdict=fit.verdict,
        reason=fit.reason,
        lambda_fixed=window.lambda_fixed,
        parameters={name: ParameterEstimate(**asdict(e)) for name, e in fit.parameters.items()},
        covariance=covariance_of(fit),
        chi2_per_dof=fit.chi2_per_dof,
        warnings=fit.warnings,
    )


def flatness_lines(found: SlidingFit) -> list[str]:
    """For the terminal: one line per constant, then why windows are missing."""
    lines = []
    for name in found.constants:
        flat = found.flatness(name)
        if flat is not None:
            slope = flat.slope_per_s / flat.slope_sd
            lines.append(
                f"{name:22} {flat.mean:.8g} +- {flat.mean_sd:.2g}   chi2/dof {flat.chi2_per_dof:.2f} "
                f"(so much by chance: {flat.probability:.2g})   slope {slope:+.1f} sd"
            )
    good = sum(w.fit.verdict == "good" for w in found.windows)
    if good and not lines:
        lines.append(f"good windows of {found.window_s:.4g} s: {good}; a slope needs three, so shorten them")
    held = sum(w.lambda_fixed for w in found.windows)
    if held:
        lines.append(f"lambda held at the D30 value in {held} of {len(found.windows)} windows")
    for reason in dict.fromkeys(_short(w) for w in found.windows if w.fit.verdict != "good"):
        at = [w.centre_s for w in found.windows if w.fit.verdict != "good" and _short(w) == reason]
        lines.append(f"refused at {', '.join(f'{t:.3f}' for t in at)} s: {reason}")
    return lines


def _short(window: WindowFit) -> str:
    return (window.fit.reason or "").partition(":")[0]


def amplitude_course(found: SlidingFit) -> tuple[list[float], list[float], list[float]]:
    """(start in s, phi_max in degrees, its standard deviation) of the good windows."""
    rows = [(w.start_s, w.fit.parameters["phi_max_rad"]) for w in found.windows if w.fit.verdict == "good"]
    return (
        [t for t, _ in rows],
        [math.degrees(e.value) for _, e in rows],
        [math.degrees(e.std) if e.std is not None else 0.0 for _, e in rows],
    )
