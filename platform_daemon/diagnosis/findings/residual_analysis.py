"""The anatomy of what a fit leaves over, as plain arrays: in time, by frequency, by harmonic, from shot to shot."""

from __future__ import annotations

import math
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.regression.parameters import clean_record, held_strengths, public_parameters
from platform_daemon.diagnosis.regression.prediction import unpredicted, window_of
from platform_daemon.diagnosis.regression.torque_response import sample_motion
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.observation_model import DipoleObservation
from platform_daemon.estimation.noise.coloured import sd_at
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError
from platform_daemon.estimation.sliding_window import ReferenceRefusedError, SlidingFit, fit_sliding

_LIMITS = THRESHOLDS.findings
HARMONICS = tuple(range(1, _LIMITS.drawn_harmonics + 1))


@dataclass(frozen=True, kw_only=True)
class SpectralLine:
    """A line in the spectrum of a residual: channel, frequency in Hz, amplitude, power over that of the noise."""

    channel: int
    frequency_hz: float
    amplitude: float
    over_noise: float


@dataclass(frozen=True, kw_only=True)
class Spectrum:
    """Amplitudes (channels, k) of the residual and what the noise alone would give, at frequencies (k,) in Hz."""

    frequency_hz: Array
    amplitude: Array
    noise: Array
    lines: tuple[SpectralLine, ...]


@dataclass(frozen=True, kw_only=True)
class HarmonicCourse:
    """Harmonics 1 .. 5 of the residual in the local frame, in stretches of the window.

    Attributes:
        time_s, angle_rad: middle of each stretch, and the mean amplitude of the swing there, (n,).
        axes: names of the local axes; "angle" for an angle.
        cosine, sine: (axes, harmonics, n), with the phase of the swing (0 at its turning point).
        sd: (axes, harmonics, n) of each of them.
    """

    time_s: Array
    angle_rad: Array
    axes: tuple[str, ...]
    cosine: Array
    sine: Array
    sd: Array

    @property
    def size(self) -> Array:
        """(axes, harmonics, n)."""
        return np.hypot(self.cosine, self.sine)


@dataclass(frozen=True)
class ResidualAnalysis:
    """What is left of one shot.

    Attributes:
        name: of the shot.
        time_s: (n,) of every sample of the window.
        residual: (channels, n) in the record's unit; slow: its part below 6.5 fundamentals, where the model acts.
        sd: (channels,) of the measured noise.
        whiteness: (channels,) mean square of the residual over that of the noise; 1: nothing but noise.
        in_band: (channels,) the same below 6.5 fundamentals.
        at_start: (channels,) the same in the first 20 ms.
        spectrum, harmonics: see there; harmonics None where the motion cannot be followed.
    """

    name: str
    time_s: Array
    residual: Array
    slow: Array
    sd: Array
    whiteness: Array
    in_band: Array
    at_start: Array
    spectrum: Spectrum
    harmonics: HarmonicCourse | None


@dataclass(frozen=True, kw_only=True)
class Scatter:
    """One parameter from shot to shot: values and standard deviations (n,), and its drift with that of chance."""

    name: str
    values: Array
    sd: Array
    drift_per_shot: float
    drift_sd: float


def analyse_residual(at: JointFit, k: int) -> ResidualAnalysis:
    """Of shot k."""
    prepared = at.prepared[k]
    noise, rate_hz = prepared.shot.noise, prepared.shot.rate_hz
    first, last = window_of(prepared)
    residual = unpredicted(at, k)
    sd = np.asarray(noise.sd)
    f_nat_hz = at.states[k].dynamics.w / (2.0 * math.pi)
    spectrum, in_band = _spectrum(residual, noise, rate_hz, THRESHOLDS.shots.pass_band * f_nat_hz)
    squares = (residual / sd[:, None]) ** 2
    begin = max(1, round(_LIMITS.at_start_s * rate_hz))
    return ResidualAnalysis(
        name=prepared.shot.name,
        time_s=np.arange(first, last) / rate_hz,
        residual=residual,
        slow=_below(residual, rate_hz, THRESHOLDS.shots.pass_band * f_nat_hz),
        sd=sd,
        whiteness=squares.mean(axis=1),
        in_band=in_band,
        at_start=squares[:, :begin].mean(axis=1),
        spectrum=spectrum,
        harmonics=_harmonics(at, k, residual),
    )


def typical_shot(at: JointFit) -> int:
    """The shot whose residual is in the middle of all."""
    return int(np.argsort([a.chi2 / s.dof for a, s in zip(at.linear, at.prepared, strict=True)])[len(at.linear) // 2])


def _below(residual: Array, rate_hz: float, highest_hz: float) -> Array:
    """The part of a residual (channels, n) below a frequency."""
    n = residual.shape[1]
    bins = np.fft.rfft(residual, axis=1)
    bins[:, np.fft.rfftfreq(n, 1.0 / rate_hz) > highest_hz] = 0.0
    return np.asarray(np.fft.irfft(bins, n, axis=1))


def _spectrum(residual: Array, noise: NoiseModel, rate_hz: float, band_hz: float) -> tuple[Spectrum, Array]:
    """The spectrum, and the power below band_hz over that of the noise, (channels,)."""
    n = residual.shape[1]
    window = np.blackman(n)
    frequency = np.asarray(np.fft.rfftfreq(n, 1.0 / rate_hz)[1:], dtype=np.float64)
    amplitude: Array = np.abs(np.fft.rfft(residual * window, axis=1))[:, 1:] * (2.0 / window.sum())
    density = np.stack([np.interp(frequency, noise.frequency_hz, row) for row in noise.psd])
    expected: Array = np.sqrt(2.0 * density * rate_hz * np.sum(window**2)) / window.sum()
    below = frequency < band_hz
    in_band = np.sum(amplitude[:, below] ** 2, axis=1) / np.sum(expected[:, below] ** 2, axis=1)
    return Spectrum(
        frequency_hz=frequency, amplitude=amplitude, noise=expected, lines=_lines(frequency, amplitude, expected)
    ), in_band


def _lines(frequency: Array, amplitude: Array, expected: Array) -> tuple[SpectralLine, ...]:
    """The strongest lines, each once per channel."""
    found = []
    over = (amplitude / expected) ** 2
    for channel, row in enumerate(over):
        row = row.copy()
        for _ in range(_LIMITS.most_lines):
            k = int(np.argmax(row))
            if row[k] < _LIMITS.line_power:
                break
            found.append(
                SpectralLine(
                    channel=channel,
                    frequency_hz=float(frequency[k]),
                    amplitude=float(amplitude[channel, k]),
                    over_noise=float(row[k]),
                )
            )
            low, high = _line_ends(row, k)
            row[low:high] = 0.0
    return tuple(sorted(found, key=lambda line: -line.over_noise)[: _LIMITS.most_lines])


def _line_ends(row: Array, k: int) -> tuple[int, int]:
    """Bins that belong to the same line: down to the noise, or a lobe's width at least."""
    low, high = k, k + 1
    while low > 0 and row[low - 1] > _LIMITS.line_power / _LIMITS.line_end:
        low -= 1
    while high < row.size and row[high] > _LIMITS.line_power / _LIMITS.line_end:
        high += 1
    return max(0, low - _LIMITS.lobe_bins), min(row.size, high + _LIMITS.lobe_bins)


def _harmonics(at: JointFit, k: int, residual: Array) -> HarmonicCourse | None:
    """Least-squares harmonics of the swing in stretches of the window."""
    prepared = at.prepared[k]
    try:
        motion = sample_motion(prepared, at.hypothesis.augmented, at.full_state(k))
    except LostTrajectoryError:
        return None
    first, _ = window_of(prepared)
    whole = np.zeros((residual.shape[0], prepared.shot.record.samples.shape[1]))
    whole[:, first : first + residual.shape[1]] = residual
    local, axes, frame = _local(at, k, prepared.at_instants(whole))
    weight = np.concatenate([np.full(g.count, float(g.factor)) for g in prepared.grids])
    f_nat_hz = at.states[k].dynamics.w / (2.0 * math.pi)
    time = prepared.time_s
    periods = (time[-1] - time[0]) * f_nat_hz
    count = max(
        1,
        min(_LIMITS.few_stretches, int(periods / _LIMITS.short_stretch_periods)),
        min(_LIMITS.stretches, int(periods / _LIMITS.stretch_periods)),
    )
    which = np.minimum(((time - time[0]) / (time[-1] - time[0]) * count).astype(int), count - 1)
    level = sd_at(prepared.shot.noise, np.array(HARMONICS) * f_nat_hz, prepared.shot.rate_hz)
    level = np.sqrt(np.einsum("ac,ch->ah", frame**2, level**2))
    shape = (len(axes), len(HARMONICS), count)
    cosine, sine, sd = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    middle, angle = np.zeros(count), np.zeros(count)
    for n in range(count):
        here = which == n
        waves = _waves(motion.phase[here])
        root = np.sqrt(weight[here])
        sizes = np.linalg.lstsq(waves * root[:, None], (local[:, here] * root).T, rcond=None)[0]
        cosine[:, :, n], sine[:, :, n] = sizes[1::2].T, sizes[2::2].T
        sd[:, :, n] = level * math.sqrt(2.0 / weight[here].sum())
        middle[n], angle[n] = time[here].mean(), motion.amplitude[here].mean()
    return HarmonicCourse(time_s=middle, angle_rad=angle, axes=axes, cosine=cosine, sine=sine, sd=sd)


def _waves(phase: Array) -> Array:
    """Columns 1, cos, sin of every harmonic, (m, 1 + 2 harmonics)."""
    columns = [np.ones_like(phase)]
    for h in HARMONICS:
        columns += [np.cos(h * phase), np.sin(h * phase)]
    return np.stack(columns, axis=1)


def _local(at: JointFit, k: int, residual: Array) -> tuple[Array, tuple[str, ...], Array]:
    """(residual in the local frame (axes, m), names of the axes, the frame (axes, channels))."""
    observation = at.states[k].observation
    if isinstance(observation, DipoleObservation):
        frame = observation.rotation.T
        return frame @ residual, ("u", "v", "w"), frame
    names = ("angle",) if residual.shape[0] == 1 else tuple(f"channel {c}" for c in range(residual.shape[0]))
    return residual, names, np.eye(residual.shape[0])


def sliding_windows(at: JointFit, k: int) -> SlidingFit | None:
    """Fits along shot k with the effects held; None if it is too short for windows."""
    record, fixed = clean_record(at, k), held_strengths(at, k)
    # An angle tells its frequency in few periods, and pendulums swing few of them.
    period_s = 2.0 * math.pi / at.states[k].dynamics.w
    window_s = _LIMITS.angle_window_periods * period_s if record.quantity == "angle" else None
    try:
        return fit_sliding(
            record, at.hypothesis.augmented, window_s, noise=at.prepared[k].shot.noise, fixed=fixed or None
        )
    except (ReferenceRefusedError, ValueError):
        return None


def scatter(at: JointFit, pool: Executor) -> tuple[Scatter, ...]:
    """Parameters from shot to shot, with their drift along the series; none for a single shot."""
    shots = [p for p in pool.map(lambda k: _parameters(at, k), range(len(at.prepared))) if p is not None]
    if len(shots) < 2:
        return ()
    return tuple(_course(name, [s[name] for s in shots]) for name in shots[0] if all(name in s for s in shots))


def _parameters(at: JointFit, k: int) -> dict[str, tuple[float, float]] | None:
    try:
        found = public_parameters(at, k).parameters
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return None
    return {name: (e.value, e.std) for name, e in found.items() if e.std is not None}


def _course(name: str, rows: list[tuple[float, float]]) -> Scatter:
    """A straight line through the values: the drift, its error from their own scatter about it."""
    values, sd = np.array([r[0] for r in rows]), np.array([r[1] for r in rows])
    place = np.arange(values.size) - 0.5 * (values.size - 1)
    slope = float(place @ values / (place @ place))
    rest = values - values.mean() - slope * place
    spread = float(np.sqrt(rest @ rest / (values.size - 2))) if values.size > 2 else math.nan
    return Scatter(
        name=name, values=values, sd=sd, drift_per_shot=slope, drift_sd=spread / float(np.sqrt(place @ place))
    )
