"""Additive effects are a sum with the signal: tones, decaying oscillations, decaying offsets."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from platform_daemon.diagnosis.shots.linearisation import Linearisation
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array

from .effect import Candidate, Detail, Effect
from .receiver import AXES

_LIMITS = THRESHOLDS.effects
MAINS = Effect(
    id="mains_interference",
    unit="A m^2/s",
    sign=0,
    separates=("blank_shots",),
    signature="lines at multiples of 50 or 60 Hz, in blank shots too",
    source="mains",
)
LINE = Effect(
    id="spectral_line",
    unit="A m^2/s",
    sign=0,
    separates=("blank_shots",),
    signature="a line that is as strong at the end, in blank shots too",
    source="switching converters, motors, other instruments",
)
SIDE_MODE = Effect(
    id="side_mode",
    unit="A m^2/s",
    sign=0,
    separates=("other_excitation_axis", "second_amplitude"),
    signature="a line that decays, with a phase tied to the excitation",
    source="modes of the suspended magnet other than its rotation",
)
TRANSIENT = Effect(
    id="switch_transient",
    unit="A m^2/s",
    sign=0,
    separates=("blank_shots",),
    signature="an offset that decays from the start of the window",
    source="charge of the switch, recovery of the amplifier",
)
ZERO_DRIFT = Effect(
    id="zero_drift",
    unit="rad/s",
    sign=0,
    separates=("longer_window",),
    signature="the middle between two turning points moves with time",
    source="a support or a camera that moves, an encoder's zero",
)

OSCILLATIONS = frozenset({MAINS, LINE, SIDE_MODE})  # found in a residual, beside whatever acts on the motion


def tone(effect: Effect, frequencies_hz: tuple[float, ...], base_hz: float, trials: float) -> Candidate:
    """Steady tones on all channels, their phases and sizes each shot's own."""
    columns = partial(_waves, frequencies_hz, math.inf, None)
    detail = Detail(frequency_hz=base_hz)

    def near(bins_hz: float) -> list[Candidate]:
        places = [step * bins_hz + base_hz for step in _LIMITS.tone_moves_bins]
        return [tone(effect, (f,), f, trials) for f in places]

    moves = near if len(frequencies_hz) == 1 and effect is LINE else None
    return Candidate(
        effect, detail, columns=columns, shared=False, size=0, trials=trials, near=moves, tones_hz=frequencies_hz
    )


def side_mode(
    frequency_hz: float, tau_s: float, channel: int | None, channels: int, *, shared: bool, trials: float
) -> Candidate:
    """A decaying oscillation on one channel of the record, or on all of them."""
    count = 2 * (channels if channel is None else 1)
    detail = Detail(_axis(channel, channels), frequency_hz, tau_s)
    columns = partial(_waves, (frequency_hz,), tau_s, channel)
    parts: tuple[Candidate, ...] = ()
    if channel is None and shared:
        each = [side_mode(frequency_hz, tau_s, c, channels, shared=True, trials=trials) for c in range(channels)]
        parts = tuple(each)

    def near(share: float) -> list[Candidate]:
        """In steps of a third of the line's width and of a quarter of the decay time."""
        width_hz, rest = share / (2.0 * math.pi * tau_s), (channel, channels)
        places = [
            (frequency_hz + a * width_hz, tau_s * _LIMITS.side_mode_ratio ** (share * b))
            for a in (-1, 0, 1)
            for b in _LIMITS.side_mode_moves
        ]
        return [side_mode(f, tau, *rest, shared=shared, trials=trials) for f, tau in places]

    return Candidate(
        SIDE_MODE, detail, columns=columns, shared=shared, size=count, parts=parts, near=near, trials=trials
    )


def transient(tau_s: float, channel: int | None, channels: int, *, trials: float) -> Candidate:
    """A decaying offset on one channel of the record, or on all of them."""
    count = channels if channel is None else 1
    columns = partial(_offsets, tau_s, channel)
    every = range(channels) if channel is None and channels > 1 else ()
    parts = tuple(transient(tau_s, c, channels, trials=trials) for c in every)
    detail = Detail(_axis(channel, channels), tau_s=tau_s)

    def near(share: float) -> list[Candidate]:
        places = [tau_s * _LIMITS.transient_ratio ** (share * step) for step in _LIMITS.transient_moves]
        return [transient(tau, channel, channels, trials=trials) for tau in places]

    return Candidate(TRANSIENT, detail, columns=columns, size=count, parts=parts, near=near, trials=trials)


def zero_drifts(seconds: float) -> list[Candidate]:
    """An angle's zero that moves at a steady rate through a window of this length, or that settles in it."""
    steady = Candidate(ZERO_DRIFT, columns=lambda linearisation: np.asarray(linearisation.time_s[None, None]), size=1)
    return [steady, *(_settling_zero(share * seconds) for share in _LIMITS.settling_zero_shares)]


def _settling_zero(tau_s: float) -> Candidate:
    """Its rate at the first sample, with the time constant of its end."""

    def near(share: float) -> list[Candidate]:
        return [_settling_zero(tau_s * _LIMITS.zero_ratio ** (share * step)) for step in _LIMITS.zero_moves]

    def columns(linearisation: Linearisation) -> Array:
        return np.asarray(-tau_s * np.expm1(-linearisation.time_s / tau_s)[None, None])

    return Candidate(ZERO_DRIFT, Detail(tau_s=tau_s), columns=columns, size=1, near=near)


def _axis(channel: int | None, channels: int) -> str | None:
    return AXES[channel] if channel is not None and channels == len(AXES) else None


def _spread(rows: Array, channel: int | None, channels: int) -> Array:
    """Columns (k, channels, m) that put rows (j, m) on one channel, or on every channel for itself."""
    which = range(channels) if channel is None else [channel]
    out = np.zeros((len(which) * rows.shape[0], channels, rows.shape[1]))
    for n, c in enumerate(which):
        out[n * rows.shape[0] : (n + 1) * rows.shape[0], c] = rows
    return out


def _filter_gain(linearisation: Linearisation, frequency_hz: float) -> Array:
    """Gain of the decimation filters at a frequency, at every instant (m,)."""
    rate, parts = linearisation.prepared.shot.rate_hz, []
    for g in linearisation.prepared.grids:
        half = g.taps.size // 2
        turn = 2.0 * np.pi * frequency_hz / rate * np.arange(-half, half + 1)
        parts.append(np.full(g.count, float(np.sum(g.taps * np.cos(turn)))))
    return np.concatenate(parts)


def _waves(frequencies_hz: tuple[float, ...], tau_s: float, channel: int | None, linearisation: Linearisation) -> Array:
    rows = []
    fall = np.exp(-linearisation.time_s / tau_s)
    for f in frequencies_hz:
        turn = 2.0 * np.pi * f * linearisation.time_s
        size = fall * _filter_gain(linearisation, f)
        rows += [size * np.cos(turn), size * np.sin(turn)]
    return _spread(np.stack(rows), channel, linearisation.residual.shape[0])


def _offsets(tau_s: float, channel: int | None, linearisation: Linearisation) -> Array:
    fall = np.exp(-linearisation.time_s / tau_s)
    return _spread(fall[None], channel, linearisation.residual.shape[0])
