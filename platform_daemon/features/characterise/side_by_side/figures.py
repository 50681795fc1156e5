"""Several specimens on common axes: a shot of each with its fit, envelopes, and the curves of a noise sweep."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from platform_daemon.core.reporting.figures import COLOURS, as_written, new_figure
from platform_daemon.features.characterise.figures import draw_fit
from platform_daemon.features.characterise.schema import CharacterisationReport
from platform_daemon.features.characterise.tables import CharacterisationTask, shown_shot

from .folder import NamedFigure
from .noise_schema import NoisePoint, NoiseSweepReport

_LABELS = {"f_nat_hz": "median absolute deviation of $f_{nat}$ / Hz", "orientation": "median orientation error / °"}


def measured_figures(
    reports: Mapping[str, CharacterisationReport],
    tasks: Mapping[str, CharacterisationTask],
    noise: NoiseSweepReport | None,
) -> Iterator[NamedFigure]:
    """fig:fit_plot of each specimen, fig:amplitude_plot, and fig:noise_plot if there is a sweep.

    Raises PlatformError for a recording that can no longer be read.
    """
    for name, report in reports.items():
        shot = shown_shot(tasks[name], report)
        windows = [f.window_s for f in report.d30_fits.good_frames if f.frame == report.shown_frame]
        if shot is not None and windows and windows[0] is not None:
            caption = f"fig:fit_plot: {name}, the shot whose D30 fit has the median R²"
            yield NamedFigure(f"fit_plot_{name}", caption, draw_fit(shot, windows[0]))
    if any(report.envelopes for report in reports.values()):
        caption = "fig:amplitude_plot: envelopes along u and v, and frequency, by the D30 fits; dashed: end of D30"
        yield NamedFigure("amplitude_plot", caption, draw_amplitudes(reports))
    if noise is not None:
        caption = "fig:noise_plot: N50 fits with white noise added; band: 95 % by bootstrap; dashed: predicted"
        yield NamedFigure("noise_plot", caption, draw_noise(noise, list(reports)))


def draw_amplitudes(reports: Mapping[str, CharacterisationReport]) -> Figure:
    """All on common axes."""
    figure = new_figure(12, 3.6)
    panels = figure.subplots(1, 3)
    keys = ("u_am2_per_s", "v_am2_per_s", "frequency_minus_f_nat_hz")
    labels = ("û: dm/dt / A m² s⁻¹", "v̂: dm/dt / A m² s⁻¹", "f − $f_{nat}$ / Hz")
    for axes, key, label in zip(panels, keys, labels, strict=True):
        for k, (name, report) in enumerate(reports.items()):
            if report.envelopes and report.d30.duration_s is not None:
                found, colour = report.envelopes[0], COLOURS[k % len(COLOURS)]
                axes.plot(found.t_s, getattr(found, key), color=colour, lw=1.2, label=as_written(name))
                axes.axvline(report.d30.duration_s.median, color=colour, ls="--", lw=0.8)
        axes.set(xlabel="time after the first RX sample / s", ylabel=label)
        axes.margins(x=0.0)
    panels[0].legend(fontsize=8)
    return figure


def draw_noise(noise: NoiseSweepReport, names: Sequence[str]) -> Figure:
    """Both quantities over the level, with their intervals and predictions; dotted vertical: break-even."""
    figure = new_figure(12, 4.2)
    for axes, (quantity, label) in zip(figure.subplots(1, 2), _LABELS.items(), strict=True):
        for k, (name, curve) in enumerate(zip(names, noise.curves, strict=True)):
            level = [p.level_am2_per_s for p in curve.points]
            told = np.array([_shown(p, quantity) for p in curve.points])
            colour = COLOURS[k % len(COLOURS)]
            axes.plot(level, told[:, 0], "o-", ms=3, lw=1.0, color=colour, label=as_written(name))
            axes.fill_between(level, told[:, 1], told[:, 2], color=colour, alpha=0.15, lw=0)
            axes.plot(level, told[:, 3], "--", lw=1.0, color=colour)
        for found in noise.break_even:
            if found.quantity == quantity and found.level_am2_per_s is not None:
                text = f"break-even at {found.level_am2_per_s:.2g} A m² s⁻¹"
                axes.axvline(found.level_am2_per_s, color="k", ls=":", lw=1.0, label=text)
        axes.set(xscale="log", yscale="log", xlabel="level of noise / A m² s⁻¹", ylabel=label)
        axes.legend(fontsize=8)
    return figure


def _shown(point: NoisePoint, quantity: str) -> list[float]:
    """Value, ends of its interval, prediction; nan: not known."""
    if quantity == "f_nat_hz":
        value, interval, factor = point.f_nat_mad_hz, point.f_nat_mad_interval_hz, 1.0
        predicted = point.f_nat_mad_predicted_hz
    else:
        value, interval, factor = point.orientation_median_rad, point.orientation_interval_rad, math.degrees(1.0)
        predicted = point.orientation_predicted_rad
    low, high = (math.nan, math.nan) if interval is None else interval
    return [factor * x for x in (math.nan if value is None else value, low, high, predicted)]
