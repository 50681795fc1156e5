"""Pictures of a ring-down for people who would rather look than read; matplotlib, no screen needed."""

from __future__ import annotations

import textwrap
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from platform_daemon.core.reporting.figures import COLOURS, as_written, png_of, save_figure
from platform_daemon.core.reporting.numbers import estimates_text
from platform_daemon.estimation.result import FitResult

from .decimation import min_max_decimate
from .plot_data import RingDownPlotData

_CAPTION = 110  # characters that a line above the picture takes
_LINE = 0.021  # of the title, share of the height
_USUAL_HZ, _SLOWEST_HZ = 212.0, 50.0
BUCKET_S = 0.012  # longer than two periods of 212 Hz, so that the filled band shows no beating with the buckets


def draw(picture: RingDownPlotData) -> Figure:
    """Whole record, a few periods with the fit over them, residual, spectrum."""
    title = f"{picture.title}\n{textwrap.fill(caption(picture.fit), _CAPTION)}"
    figure = Figure(figsize=(11, 9))
    FigureCanvasAgg(figure)
    # Places of our own: a layout engine draws everything twice, which takes half of the time of a picture.
    top = 0.985 - _LINE * (title.count("\n") + 1)
    places = {"left": 0.08, "right": 0.985, "bottom": 0.055, "top": top, "hspace": 0.32}
    whole, zoom, rest, spectrum = figure.subplots(4, 1, height_ratios=(3, 3, 2, 3), gridspec_kw=places)
    figure.suptitle(as_written(title), y=0.99, fontsize=11)
    _whole(whole, picture)
    _zoom(zoom, picture)
    _residual(rest, picture)
    _spectrum(spectrum, picture)
    return figure


def caption(fit: FitResult) -> str:
    """What the fit says, in one line."""
    if fit.verdict != "good":
        return f"fit refused: {fit.reason}"
    return f"{estimates_text(fit.parameters)}, χ²/dof {fit.chi2_per_dof:.3f}"


def save_png(picture: RingDownPlotData, path: Path) -> None:
    """Write the picture as PNG; the file appears whole or not at all."""
    save_figure(draw(picture), path)


def ring_down_png(picture: RingDownPlotData) -> bytes:
    """The picture as PNG."""
    return png_of(draw(picture), 110)


def prepare_pictures() -> None:
    """Load what the first picture needs, which takes longer than to draw it: matplotlib, its fonts, powers of ten."""
    figure = Figure()
    axes = figure.subplots()
    axes.semilogy([1.0, 2.0], [1e-3, 1e3], label="χ²")
    axes.legend()
    png_of(figure, 20)


def _time(n: int, rate_hz: float) -> NDArray[np.float64]:
    return np.arange(n) / rate_hz


def buckets(samples: NDArray[np.float64], rate_hz: float) -> int:
    """Into how many parts samples (c, n) are cut to be drawn as a band."""
    return max(50, min(1200, round(samples.shape[1] / rate_hz / BUCKET_S)))


def _whole(axes: Axes, p: RingDownPlotData) -> None:
    size, low, high = min_max_decimate(p.measured, buckets(p.measured, p.sampling_rate_hz))
    t = _time(low.shape[1], p.sampling_rate_hz / size)
    for c, name in enumerate(p.channels):
        axes.fill_between(t, low[c], high[c], color=COLOURS[c % 3], alpha=0.75, lw=0.3, label=as_written(name))
    if p.fit.window_s is not None:
        axes.axvline(p.fit.window_s, color="k", ls="--", lw=0.8)
        axes.annotate(
            " end of the fitted window ",
            (p.fit.window_s, 0.03),
            xycoords=("data", "axes fraction"),
            ha="right" if p.fit.window_s > 0.7 * t[-1] else "left",
            fontsize=8,
        )
    axes.set(ylabel=p.unit, xlabel="time after the first RX sample / s")
    axes.legend(loc="upper right", ncols=3, fontsize=8)


def _slowness(fit: FitResult) -> float:
    """By how much slower a pendulum swings than a resonator, which the picture is made for; 1: it is one."""
    f_nat = fit.parameters.get("f_nat_hz")
    return 1.0 if f_nat is None or f_nat.value > _SLOWEST_HZ else _USUAL_HZ / f_nat.value


def _zoom(axes: Axes, p: RingDownPlotData) -> None:
    slowness = _slowness(p.fit)
    n = min(p.measured.shape[1], round(0.025 * slowness * p.sampling_rate_hz))
    unit, scale = ("ms", 1e3) if slowness == 1.0 else ("s", 1.0)
    t = _time(n, p.sampling_rate_hz) * scale
    for c, name in enumerate(p.channels):
        axes.plot(t, p.measured[c, :n], ".", ms=2, color=COLOURS[c % 3], label=as_written(f"{name} measured"))
        if p.model is not None:
            axes.plot(t, p.model[c, :n], lw=0.9, color="k", label="model" if c == 0 else None)
    axes.set(ylabel=p.unit, xlabel=f"time / {unit}")
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.3 * (high - low))
    axes.legend(loc="upper right", ncols=4, fontsize=8)


def _residual(axes: Axes, p: RingDownPlotData) -> None:
    if p.model is None:
        axes.text(0.5, 0.5, "no fit, no residual", ha="center", transform=axes.transAxes)
        axes.set_axis_off()
        return
    n = min(p.measured.shape[1], p.model.shape[1])
    size, low, high = min_max_decimate(p.measured[:, :n] - p.model[:, :n], buckets(p.measured, p.sampling_rate_hz))
    t = _time(low.shape[1], p.sampling_rate_hz / size)
    for c in reversed(range(len(p.channels))):
        axes.fill_between(t, low[c], high[c], color=COLOURS[c % 3], alpha=0.6, lw=0.2)
    axes.set(ylabel=f"residual\n{p.unit}", xlabel="time after the first RX sample / s")


def _spectrum(axes: Axes, p: RingDownPlotData) -> None:
    n = (
        p.measured.shape[1]
        if p.fit.window_s is None
        else min(p.measured.shape[1], round(p.fit.window_s * p.sampling_rate_hz))
    )
    window = np.blackman(n)
    f = np.fft.rfftfreq(n, 1 / p.sampling_rate_hz)
    slowness = _slowness(p.fit)
    shown = (f > 20 / slowness) & (f < 2500 / slowness)
    for c, name in enumerate(p.channels):
        lines = np.abs(np.fft.rfft(p.measured[c, :n] * window)) * 2 / window.sum()
        axes.semilogy(f[shown], lines[shown], color=COLOURS[c % 3], lw=0.7, label=as_written(name))
        if p.model is not None:
            rest = np.abs(np.fft.rfft((p.measured[c, :n] - p.model[c, :n]) * window)) * 2 / window.sum()
            axes.semilogy(f[shown], rest[shown], color=COLOURS[c % 3], lw=0.4, alpha=0.4)
    axes.set(ylabel=f"amplitude\n{p.unit}", xlabel="frequency / Hz (pale: residual)")
