"""Additive effects stand in the data beside the signal: tones, decaying oscillations, decaying offsets."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from platform_daemon.estimation import Array

from ..shots.linearisation import Linearisation
from .effect import Candidate, Detail, Effect
from .receiver import AXES

MAINS = Effect(
    "mains_interference", "A m^2/s", 0, ("blank_shots",), "lines at multiples of 50 or 60 Hz, in blank shots too",
    "mains",
)  # fmt: skip
LINE = Effect(
    "spectral_line", "A m^2/s", 0, ("blank_shots",), "a line that is as strong at the end, in blank shots too",
    "switching converters, motors, other instruments",
)  # fmt: skip
SIDE_MODE = Effect(
    "side_mode", "A m^2/s", 0, ("other_excitation_axis", "second_amplitude"),
    "a line that decays, with a phase tied to the excitation", "modes of the suspended magnet other than its rotation",
)  # fmt: skip
TRANSIENT = Effect(
    "switch_transient", "A m^2/s", 0, ("blank_shots",), "an offset that decays from the start of the window",
    "charge of the switch, recovery of the amplifier",
)  # fmt: skip
ZERO_DRIFT = Effect(
    "zero_drift", "rad/s", 0, ("longer_window",), "the middle between two turning points moves with time",
    "a support or a camera that moves, an encoder's zero",
)  # fmt: skip
_SETTLING = (0.05, 0.2, 0.6)  # time constants of a zero that settles, of the window
MAINS_TOLERANCE = 0.004


def tone(effect: Effect, frequencies_hz: tuple[float, ...], base_hz: float, trials: float) -> Candidate:
    """Steady tones on all channels, their phases and sizes each shot's own."""
    columns = partial(_waves, frequencies_hz, math.inf, None)
    detail = Detail(frequency_hz=base_hz)

    def near(bins_hz: float) -> list[Candidate]:
        places = [step * bins_hz + base_hz for step in (-0.3, -0.15, 0.0, 0.15, 0.3)]
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
            (frequency_hz + a * width_hz, tau_s * 1.25 ** (share * b)) for a in (-1, 0, 1) for b in (-2, -1, 0, 1, 2)
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
        places = [tau_s * 1.2 ** (share * step) for step in (-3, -2, -1, 0, 1, 2, 3)]
        return [transient(tau, channel, channels, trials=trials) for tau in places]

    return Candidate(TRANSIENT, detail, columns=columns, size=count, parts=parts, near=near, trials=trials)


def zero_drifts(seconds: float) -> list[Candidate]:
    """An angle's zero that moves at a steady rate through a window of this length, or that settles in it."""
    steady = Candidate(ZERO_DRIFT, columns=lambda look: np.asarray(look.time_s[None, None]), size=1)
    return [steady, *(_settling_zero(share * seconds) for share in _SETTLING)]


def _settling_zero(tau_s: float) -> Candidate:
    """Its rate at the first sample, with the time constant of its end."""

    def near(share: float) -> list[Candidate]:
        return [_settling_zero(tau_s * 1.4 ** (share * step)) for step in (-2, -1, 0, 1, 2)]

    def columns(look: Linearisation) -> Array:
        return np.asarray(-tau_s * np.expm1(-look.time_s / tau_s)[None, None])

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


def _passed(look: Linearisation, frequency_hz: float) -> Array:
    """What the filters of the grids let through at a frequency, at every instant (m,)."""
    rate, parts = look.started.shot.rate_hz, []
    for g in look.started.grids:
        half = g.taps.size // 2
        turn = 2.0 * np.pi * frequency_hz / rate * np.arange(-half, half + 1)
        parts.append(np.full(g.count, float(np.sum(g.taps * np.cos(turn)))))
    return np.concatenate(parts)


def _waves(frequencies_hz: tuple[float, ...], tau_s: float, channel: int | None, look: Linearisation) -> Array:
    rows = []
    fall = np.exp(-look.time_s / tau_s)
    for f in frequencies_hz:
        turn = 2.0 * np.pi * f * look.time_s
        size = fall * _passed(look, f)
        rows += [size * np.cos(turn), size * np.sin(turn)]
    return _spread(np.stack(rows), channel, look.residual.shape[0])


def _offsets(tau_s: float, channel: int | None, look: Linearisation) -> Array:
    fall = np.exp(-look.time_s / tau_s)
    return _spread(fall[None], channel, look.residual.shape[0])
