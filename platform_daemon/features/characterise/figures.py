"""Pictures of a characterisation: a shot with its fit (fig:fit_plot), envelopes and frequency (fig:amplitude_plot), and
every parameter shot by shot."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from platform_daemon.core.reporting.figures import COLOURS, as_written, new_figure
from platform_daemon.core.schemas.derived import EnvelopesReport
from platform_daemon.core.schemas.fits import FitReport
from platform_daemon.core.schemas.parameters import definition_of
from platform_daemon.features.fit.decimation import min_max_decimate
from platform_daemon.features.fit.plot_data import RingDownPlotData
from platform_daemon.features.fit.ring_down_figure import buckets

from .schema import CharacterisationReport

_MEASURED, _MODEL = COLOURS[0], COLOURS[1]
_PERIODS = 4.0  # in an inlet, as in the paper
_WINDOWS = (("n50", "N50", COLOURS[1]), ("d30", "D30", COLOURS[0]))


def draw_fit(shot: RingDownPlotData, duration_s: float) -> Figure:
    """The channel with the largest response: measurement and D30 model over the window, two inlets of four periods, and
    the residual on a scale of its own."""
    assert shot.model is not None
    rate = shot.sampling_rate_hz
    n = min(shot.measured.shape[1], round(1.1 * duration_s * rate))
    c = int(np.argmax(np.ptp(shot.measured[:, :n], axis=1)))
    measured, model = shot.measured[c, :n], shot.model[c, :n]
    figure = new_figure(11, 6.5)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(4, 1))
    above.set_title(as_written(f"{shot.title}, {shot.channels[c]} channel"), fontsize=10)
    _band(above, measured, rate, _MEASURED, "measured")
    _band(above, model, rate, _MODEL, "model, D30 fit")
    highest = float(np.max(np.abs(measured)))
    above.set(ylabel=shot.unit, ylim=(-1.15 * highest, 2.9 * highest))
    span = _PERIODS / shot.fit.parameters["f_nat_hz"].value
    for begin, place in ((0.0, (0.06, 0.60, 0.42, 0.36)), (max(0.0, duration_s - span), (0.56, 0.60, 0.42, 0.36))):
        _inlet(above, measured, model, rate, begin, span, place)
    _band(below, measured - model, rate, "0.4", "")
    for axes in (above, below):
        axes.axvline(duration_s, color="k", ls="--", lw=0.8)
    below.set(ylabel="residual", xlabel="time after the first RX sample / s (dashed: end of D30)")
    above.legend(loc="lower right", ncols=2, fontsize=8)
    return figure


def _band(axes: Axes, samples: NDArray[np.float64], rate: float, colour: str, label: str) -> None:
    """From the smallest to the largest value per bucket."""
    size, low, high = min_max_decimate(samples[None], buckets(samples[None], rate))
    time = (np.arange(low.shape[1]) + 0.5) * size / rate
    hollow = label.startswith("model")
    for edge in (low[0], high[0]) if hollow else ():
        axes.plot(time, edge, color=colour, lw=0.9, label=label)
        label = ""
    if not hollow:
        axes.fill_between(time, low[0], high[0], color=colour, alpha=0.75, lw=0.3, label=label or None)


def _inlet(
    axes: Axes,
    measured: NDArray[np.float64],
    model: NDArray[np.float64],
    rate: float,
    begin: float,
    span: float,
    place: tuple[float, float, float, float],
) -> None:
    """Four periods from `begin` on, dots measured and line the model."""
    first, last = round(begin * rate), round((begin + span) * rate)
    time = np.arange(first, min(last, measured.size)) / rate
    inside = axes.inset_axes(place)
    step = max(1, time.size // 400)
    inside.plot(time[::step], measured[first : first + time.size : step], ".", ms=2.5, color=_MEASURED)
    inside.plot(time, model[first : first + time.size], color=_MODEL, lw=0.9)
    inside.tick_params(labelsize=7)
    inside.margins(x=0.0)
    axes.indicate_inset_zoom(inside, edgecolor="0.3")


def draw_envelopes(envelopes: Sequence[EnvelopesReport], duration_s: float) -> Figure:
    """Of the D30 fit, and dashed of the N50 fit: u, v, and the frequency against f_nat."""
    figure = new_figure(11, 3.4)
    panels = figure.subplots(1, 3)
    keys = ("u_am2_per_s", "v_am2_per_s", "frequency_minus_f_nat_hz")
    labels = ("û: dm/dt / A m² s⁻¹", "v̂: dm/dt / A m² s⁻¹", "f − $f_{nat}$ / Hz")
    for axes, key, label in zip(panels, keys, labels, strict=True):
        for found, style, colour, name in zip(envelopes, ("-", "--"), COLOURS, ("D30 fit", "N50 fit"), strict=False):
            axes.plot(found.t_s, getattr(found, key), style, color=colour, lw=1.2, label=name)
        axes.axvline(duration_s, color="k", ls="--", lw=0.8)
        axes.set(xlabel="time / s", ylabel=label)
        axes.margins(x=0.0)
    panels[0].legend(fontsize=8)
    return figure


def draw_course(report: CharacterisationReport) -> Figure:
    """Every fitted parameter shot by shot in both windows, with its distribution on the right."""
    fits = {"n50": report.n50_fits, "d30": report.d30_fits}
    names = list(dict.fromkeys(n for d in (report.n50, report.d30) for n in d.parameters))
    figure = new_figure(11, 1.7 * len(names) + 0.6)
    rows = figure.subplots(len(names), 2, width_ratios=(5, 1), sharey="row", sharex="col", squeeze=False)
    for (course, histogram), name in zip(rows, names, strict=True):
        shown = definition_of(name)
        found = [(_values(fits[w], name, shown.display_factor), label, colour) for w, label, colour in _WINDOWS]
        edges = np.histogram_bin_edges(np.concatenate([values for (_, values), _, _ in found]), bins=30)
        for (frames, values), label, colour in found:
            if values.size:
                course.plot(frames, values, ".", ms=4, color=colour, label=label)
                histogram.hist(values, bins=edges, orientation="horizontal", color=colour, alpha=0.5)
        course.set_ylabel(shown.axis_label, fontsize=9)
        course.ticklabel_format(axis="y", useOffset=False)
        histogram.tick_params(labelsize=7)
    rows[0, 0].legend(fontsize=8, loc="upper right", ncols=2)
    rows[-1, 0].set_xlabel("frame")
    rows[-1, 1].set_xlabel("shots")
    return figure


def _values(report: FitReport, name: str, factor: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(frames, values) of the good fits that estimated it; phases near each other across 0."""
    found = [(f.frame, f.parameters[name].value) for f in report.good_frames if _estimated(f.parameters.get(name))]
    frames, values = (np.array(part, dtype=float) for part in zip(*found, strict=True)) if found else (np.empty(0),) * 2
    if name == "psi_start_rad" and values.size:
        middle = math.atan2(float(np.sin(values).mean()), float(np.cos(values).mean())) % (2.0 * math.pi)
        values = middle + np.remainder(values - middle + math.pi, 2.0 * math.pi) - math.pi
    return frames, values * factor


def _estimated(estimate: object) -> bool:
    return estimate is not None and getattr(estimate, "std", None) is not None
