"""Pictures of a diagnosis: what is left over before and after, in time, by frequency and by harmonic."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from platform_daemon.core.reporting.figures import AFTER, BEFORE, as_written, new_figure
from platform_daemon.core.schemas.parameters import definition_of
from platform_daemon.diagnosis.findings.residual_analysis import HARMONICS, HarmonicCourse, ResidualAnalysis, Scatter
from platform_daemon.diagnosis.report_schema import MissingTorqueMap
from platform_daemon.diagnosis.residual_comparison import SlidingComparison
from platform_daemon.estimation.sliding_window import SlidingFit
from platform_daemon.features.fit.decimation import min_max_decimate

from .report import plain

_SIDES = (("before", BEFORE), ("after", AFTER))
_POINTS = 900
_NOISE_95 = math.sqrt(-2.0 * math.log(0.05))  # 95 % of the amplitudes that noise of unit sd in both parts makes
_HARMONIC_COLOURS = ("#1b6ca8", "#d1495b", "#3a7d44", "#b07d2b", "#6a4c93")

Pair = tuple[ResidualAnalysis, ResidualAnalysis]


def channel_names(count: int, unit: str) -> tuple[str, ...]:
    """Of world axes, or of an angle."""
    return ("angle",) if unit == "rad" else ("x", "y", "z")[:count]


def draw_residual(pair: Pair, unit: str) -> Figure:
    """Residual in time, a row per channel, before and after, in units of the noise; right axis: in the unit."""
    names = channel_names(pair[0].sd.size, unit)
    figure = new_figure(11, 1.7 * len(names) + 1.3)
    rows = figure.subplots(len(names), 2, sharex=True, sharey="row", squeeze=False)
    figure.suptitle(f"{as_written(pair[0].name)}: residual over noise; dark: below 6.5 fundamentals", fontsize=11)
    for c, name in enumerate(names):
        for axes, one, (side, colour) in zip(rows[c], pair, _SIDES, strict=True):
            _band_in_time(axes, one, c, colour)
            axes.set_title(f"{name}, {side}: χ²/sample {one.whiteness[c]:.4g}", fontsize=9)
        rows[c, 0].set_ylabel("residual / σ", fontsize=9)
        right = rows[c, 1].secondary_yaxis("right", functions=_scaled(float(pair[0].sd[c])))
        right.set_ylabel(unit.replace("^2", "²"), fontsize=9)
    for axes in rows[-1]:
        axes.set_xlabel("time after the first RX sample / s")
    return figure


def _scaled(factor: float):  # type: ignore[no-untyped-def]
    return (lambda y: y * factor, lambda y: y / factor)


def _band_in_time(axes: Axes, one: ResidualAnalysis, c: int, colour: str) -> None:
    """Smallest and largest value per bucket, pale; darker: of what is below 6.5 fundamentals."""
    scaled = one.residual[c : c + 1] / one.sd[c]
    size, low, high = min_max_decimate(scaled, _POINTS)
    time = one.time_s[0] + np.arange(low.shape[1]) * size * (one.time_s[1] - one.time_s[0])
    axes.fill_between(time, low[0], high[0], color=colour, alpha=0.45, lw=0.3)
    _, low, high = min_max_decimate(one.slow[c : c + 1] / one.sd[c], _POINTS)
    axes.fill_between(time, low[0], high[0], color=colour, lw=0.5)
    axes.axhspan(-1.0, 1.0, color="k", alpha=0.15, lw=0)
    axes.axhline(0.0, color="k", lw=0.5)


def draw_spectra(pair: Pair, unit: str, f_nat_hz: float) -> Figure:
    """Amplitude spectra before and after with the noise and the lines, a panel per channel."""
    names = channel_names(pair[0].sd.size, unit)
    figure = new_figure(11, 2.3 * len(names) + 0.6)
    panels = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
    figure.suptitle(
        f"{as_written(pair[0].name)}: spectrum of the residual; dots: lines; dotted: multiples of f_nat", fontsize=11
    )
    for c, (axes, name) in enumerate(zip(panels, names, strict=True)):
        for one, (side, colour) in zip(pair, _SIDES, strict=True):
            frequency, top = _peaks(one.spectrum.frequency_hz, one.spectrum.amplitude[c], 8.5 * f_nat_hz)
            axes.semilogy(frequency, top, color=colour, lw=0.8, alpha=0.85, label=side)
            for line in (x for x in one.spectrum.lines if x.channel == c and x.frequency_hz < 8.5 * f_nat_hz):
                axes.plot(line.frequency_hz, line.amplitude, "o", ms=4, mfc="none", color=colour)
                if side == "after" or pair[1] is pair[0]:
                    text = f" {line.frequency_hz:.4g} Hz"
                    axes.annotate(text, (line.frequency_hz, line.amplitude), fontsize=7, rotation=45)
        frequency, noise = _peaks(one.spectrum.frequency_hz, one.spectrum.noise[c], 8.5 * f_nat_hz)
        # Of so many powers of noise, the largest is larger than their mean by the logarithm of their number.
        largest = math.sqrt(math.log(max(1, int(np.sum(one.spectrum.frequency_hz < 8.5 * f_nat_hz)) // _POINTS)) + 1.0)
        axes.semilogy(frequency, noise * largest, color="k", lw=0.9, label="measured noise")
        for h in range(1, 9):
            axes.axvline(h * f_nat_hz, color="0.6", lw=0.6, ls=":")
        axes.set_ylabel(f"{name} / {unit.replace('^2', '²')}", fontsize=9)
        axes.margins(y=0.15)
    panels[0].legend(loc="upper right", ncols=3, fontsize=8)
    panels[-1].set_xlabel("frequency / Hz")
    return figure


def _peaks(
    frequency: NDArray[np.float64], amplitude: NDArray[np.float64], highest_hz: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The largest amplitude in every one of some hundred bands, up to a frequency."""
    shown = frequency < highest_hz
    f, a = frequency[shown], amplitude[shown]
    size = max(1, f.size // _POINTS)
    count = f.size // size
    return f[: count * size].reshape(count, size).mean(axis=1), a[: count * size].reshape(count, size).max(axis=1)


def draw_harmonics(before: HarmonicCourse, after: HarmonicCourse, unit: str, name: str) -> Figure:
    """Harmonics 1 .. 5 of the residual: a row per local axis; against amplitude before, after; against time."""
    figure = new_figure(12, 2.5 * len(before.axes) + 0.8)
    rows = figure.subplots(len(before.axes), 4, sharey="row", squeeze=False)
    figure.suptitle(
        f"{as_written(name)}: harmonics of the residual in the local frame; grey: 95 % of noise alone", fontsize=11
    )
    for a, axis in enumerate(before.axes):
        for axes, course, side, by in zip(
            rows[a],
            (before, after, before, after),
            ("before", "after") * 2,
            ("angle",) * 2 + ("time",) * 2,
            strict=True,
        ):
            _one_axis(axes, course, a, by, max(float(before.size[a].max()), float(after.size[a].max())))
            axes.set_title(f"{axis}, {side}", fontsize=9)
        rows[a, 0].set_ylabel(unit.replace("^2", "²"), fontsize=9)
    for column, text in enumerate(("amplitude / °",) * 2 + ("time / s",) * 2):
        rows[-1, column].set_xlabel(text, fontsize=9)
    rows[0, 0].legend(fontsize=7, ncols=5, loc="upper left", handlelength=0.8, columnspacing=0.6)
    return figure


def _one_axis(axes: Axes, course: HarmonicCourse, a: int, by: str, top: float) -> None:
    x = np.degrees(course.angle_rad) if by == "angle" else course.time_s
    order = np.argsort(x)
    for k, h in enumerate(HARMONICS):
        y = course.size[a, k][order]
        axes.semilogy(x[order], y, "o-", ms=2.5, lw=0.9, color=_HARMONIC_COLOURS[k], label=f"{h}f")
    ceiling = course.sd[a].max(axis=0)[order] * _NOISE_95
    floor = 0.05 * float(ceiling.min())
    axes.fill_between(x[order], np.full(x.size, floor), ceiling, color="0.75", alpha=0.6, lw=0, zorder=0)
    axes.set_ylim(floor, 3.0 * max(top, float(ceiling.max())))


def draw_sliding_pair(pair: SlidingComparison) -> Figure:
    """Constants window by window, before and after; flat lines: the model is right."""
    before, after = pair.before, pair.after
    names = [n for n in before.constants if before.course(n)[0].size]
    figure = new_figure(11, 1.7 * (len(names) + 1) + 0.8)
    panels = figure.subplots(len(names) + 1, 1, sharex=True, squeeze=False)[:, 0]
    figure.suptitle(
        f"{as_written(pair.shot)}: fits of windows of {before.window_s:.3g} s, the effects' strengths held", fontsize=11
    )
    for axes, constant in zip(panels, names, strict=False):
        texts = []
        for found, (side, colour), shift in zip((before, after), _SIDES, (-0.004, 0.004), strict=True):
            texts.append(_constant(axes, found, constant, side, colour, shift))
        axes.set_title("   ".join(t for t in texts if t), fontsize=8, loc="left")
        axes.set_ylabel(definition_of(constant).axis_label, fontsize=9)
        axes.ticklabel_format(axis="y", useOffset=False)
    for found, (side, colour), mark in zip((before, after), _SIDES, ("s", "."), strict=True):
        rows = [
            (w.start_s, w.fit.parameters["phi_max_rad"]) for w in found.windows if "phi_max_rad" in w.fit.parameters
        ]
        starts, angles = [t for t, _ in rows], [math.degrees(e.value) for _, e in rows]
        panels[-1].plot(starts, angles, mark, ms=5, mfc="none", color=colour, label=side)
    panels[-1].set(ylabel="φ_max / °\nat window start", xlabel="time after the first RX sample / s")
    panels[-1].legend(fontsize=8)
    return figure


def _constant(axes: Axes, found: SlidingFit, name: str, side: str, colour: str, shift: float) -> str:
    factor = definition_of(name).display_factor
    time, value, sd = found.course(name)
    if not time.size:
        return ""
    moved = time + shift * (found.windows[-1].end_s - found.windows[0].start_s)
    axes.errorbar(moved, value * factor, sd * factor, fmt="o", ms=3, capsize=2, lw=0.9, color=colour)
    flat = found.flatness(name)
    if flat is None:
        return ""
    axes.axhline(flat.mean * factor, color=colour, lw=0.7, alpha=0.6)
    slope = flat.slope_per_s / flat.slope_sd
    return f"{side}: χ²/dof {flat.chi2_per_dof:.3g} (p = {flat.probability:.2g}), slope {slope:+.1f} sd"


def draw_scatter(before: Sequence[Scatter], after: Sequence[Scatter]) -> Figure:
    """Every parameter from shot to shot, before and after."""
    count = len(before)
    columns = 3 if count > 4 else 2
    figure = new_figure(11, 1.9 * -(-count // columns) + 0.6)
    panels = figure.subplots(-(-count // columns), columns, squeeze=False).ravel()
    figure.suptitle("shot to shot: red before, blue after; bars: a shot's own standard deviation", fontsize=11)
    known = {s.name: s for s in after}
    for axes, one in zip(panels, before, strict=False):
        parameter = definition_of(one.name)
        factor = parameter.display_factor
        for course, (_, colour), shift in zip((one, known.get(one.name)), _SIDES, (-0.08, 0.08), strict=True):
            if course is not None:
                place = np.arange(course.values.size) + 1 + shift
                axes.errorbar(place, course.values * factor, course.sd * factor, fmt="o", ms=3, lw=0.9, color=colour)
        axes.set_ylabel(parameter.axis_label, fontsize=8)
        axes.tick_params(labelsize=7)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.ticklabel_format(axis="y", useOffset=False)
    for axes in panels[count:]:
        axes.set_axis_off()
    return figure


def draw_torque(torque: MissingTorqueMap) -> Figure:
    """The missing torque over angle and velocity, its standard deviation, and cuts through the middle."""
    figure = new_figure(12, 4.0)
    left, right, cuts = figure.subplots(1, 3)
    figure.suptitle(f"missing torque per inertia (would lower χ² by {plain(torque.gain)})", fontsize=11)
    phi, phi_dot, value, std = (np.array(x, float) for x in (torque.phi, torque.phi_dot, torque.value, torque.std))
    _map(left, phi, phi_dot, value, signed=True)
    left.set_title("estimate", fontsize=9)
    _map(right, phi, phi_dot, std, signed=False)
    right.set_title("its standard deviation", fontsize=9)
    middle = phi.size // 2
    for x, y, sd, label, colour in (
        (phi / phi.max(), value[:, middle], std[:, middle], "φ, at φ′ = 0", AFTER),
        (phi_dot / phi_dot.max(), value[middle], std[middle], "φ′, at φ = 0", BEFORE),
    ):
        cuts.plot(x, y, color=colour, lw=1.2, label=label)
        cuts.fill_between(x, y - 2 * sd, y + 2 * sd, color=colour, alpha=0.25, lw=0)
    cuts.axhline(0.0, color="k", lw=0.5)
    cuts.set(xlabel="over its largest value", ylabel="rad/s²")
    cuts.set_title("cuts, band: 2 standard deviations", fontsize=9)
    cuts.legend(fontsize=8)
    return figure


def _map(
    axes: Axes, phi: NDArray[np.float64], phi_dot: NDArray[np.float64], values: NDArray[np.float64], *, signed: bool
) -> None:
    """values: (angles, velocities) in rad/s^2."""
    limit = float(np.nanpercentile(np.abs(values), 98)) or 1.0
    norm = TwoSlopeNorm(0.0, -limit, limit) if signed else None
    shown = axes.pcolormesh(
        np.degrees(phi), phi_dot, values.T, norm=norm, shading="nearest",
        cmap="RdBu_r" if signed else "viridis", vmax=None if signed else limit,
    )  # fmt: skip
    axes.figure.colorbar(shown, ax=axes, label="rad/s²")
    axes.set(xlabel="φ / °", ylabel="φ′ / rad s⁻¹")
