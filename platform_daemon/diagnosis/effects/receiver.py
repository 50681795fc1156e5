"""Receiver effects act on the whole signal: gains, delays, poles, crosstalk, compression.

Each column is the first-order change of the channels; `undo` takes the effect out of the data exactly, or to an order
far below the noise, so that refits with an effect are fits of the declared model to freed data. They act on the
digitiser's channels; where calibration mixes these into dm/dt, so does the column.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from platform_daemon.estimation.arrays import Array

from ..look import Look
from ..shots import Shot
from .base import Candidate, Detail, Effect

AXES = "xyz"
_CAL_2F, _TURN, _AMPLITUDE = "calibrate_2f", "turn_90_deg", "second_amplitude"
GAIN = Effect(
    "channel_gain", "1", 0, (_TURN, _CAL_2F), "v3 in N50, u2 in D30; changes sign if turned by 90 degrees",
    "calibration error; pole of a coil or an AC coupling",
)  # fmt: skip
DELAY = Effect("channel_delay", "s", 0, (_CAL_2F, _TURN), "u2 in phase, the same in every window", "filters that differ")
LOW_PASS = Effect(
    "receive_lowpass", "s", 1, (_CAL_2F, _TURN), "u2 in phase; all channels: u2 and v3 in amplitude",
    "capacitance of coil and cable, bandwidth of the amplifier",
)  # fmt: skip
COMPRESSION = Effect(
    "receiver_compression", "1/V^2", 0, (_AMPLITUDE,), "v3 and v1 grow as phi^3", "amplifier near its limit",
)  # fmt: skip
CROSSTALK = Effect("crosstalk", "1", 0, (_TURN, _CAL_2F), "v2 in phase", "coupling of coils, cables and channels")

# Central difference of order 8: exact to 1e-9 where the signal is.
_STENCIL = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
_TAYLOR = 5


def derivative(samples: Array, rate_hz: float) -> Array:
    """Time derivative of (channels, n); the four samples at either end repeat their neighbours' value."""
    inner = np.stack([np.convolve(row, _STENCIL, mode="valid") for row in samples]) * rate_hz
    return np.pad(inner, ((0, 0), (4, 4)), mode="edge")


def receiver_candidates(channels: int, quantity: str) -> list[Candidate]:
    """Everything that can happen to so many channels."""
    each = range(channels)
    if quantity == "angle":
        return [_single(GAIN, 0, _gain, _undo_gain, axis=None)]
    found = [_single(GAIN, c, _gain, _undo_gain) for c in each]
    found += [_single(DELAY, c, _delay, _undo_delay) for c in each]
    found += [_single(LOW_PASS, c, _delay, _undo_low_pass) for c in each]
    found += [Candidate(LOW_PASS, columns=_low_pass_all, undo=_undo_low_pass_all, public=_root)]
    found += [_single(COMPRESSION, c, _compression, _undo_compression) for c in each]
    found += [Candidate(COMPRESSION, columns=_compression_all, undo=_undo_compression_all)]
    found += [
        Candidate(
            CROSSTALK, Detail(start=AXES[a], end=AXES[b]), columns=partial(_mix, a, b), undo=partial(_undo_mix, a, b)
        )
        for a in each for b in each if a != b
    ]  # fmt: skip
    return found


def _single(
    effect: Effect,
    channel: int,
    columns: Callable[[int, Look], Array],
    undo: Callable[[int, Array, Shot, float], Array],
    axis: str | None = "",
) -> Candidate:
    """An effect of one channel."""
    detail = Detail(axis=AXES[channel] if axis == "" else axis)
    return Candidate(effect, detail, columns=partial(columns, channel), undo=partial(undo, channel))


def _in(look: Look, changes: Array) -> Array:
    """One column from the changes (channels, m) at the digitiser, (1, channels, m)."""
    return np.asarray((look.started.shot.from_volts @ changes)[None])


def _on(look: Look, channel: int, row: Array) -> Array:
    """One column that is `row` on one channel of the digitiser."""
    changes = np.zeros_like(look.volts)
    changes[channel] = row
    return _in(look, changes)


def _slopes(look: Look) -> Array:
    """Time derivative at the digitiser."""
    return np.asarray(look.started.shot.to_volts @ look.slope)


def _at_digitiser(work: Callable[[Array], Array], samples: Array, shot: Shot) -> Array:
    """Samples with `work` done to the digitiser's channels."""
    return np.asarray(shot.from_volts @ work(shot.to_volts @ samples))


def _gain(channel: int, look: Look) -> Array:
    return _on(look, channel, look.volts[channel])


def _undo_gain(channel: int, samples: Array, shot: Shot, strength: float) -> Array:
    def work(volts: Array) -> Array:
        volts[channel] /= 1.0 + strength
        return volts

    return _at_digitiser(work, samples, shot)


def _delay(channel: int, look: Look) -> Array:
    return _on(look, channel, -_slopes(look)[channel])


def _undo_delay(channel: int, samples: Array, shot: Shot, strength: float) -> Array:
    """y(t + delay) by Taylor's series."""

    def work(volts: Array) -> Array:
        term = volts[channel : channel + 1]
        for k in range(1, _TAYLOR + 1):
            term = derivative(term, shot.rate_hz) * (strength / k)
            volts[channel] += term[0]
        return volts

    return _at_digitiser(work, samples, shot)


def _undo_low_pass(channel: int, samples: Array, shot: Shot, strength: float) -> Array:
    """The inverse of one pole: y + tau y'."""

    def work(volts: Array) -> Array:
        volts[channel] += strength * derivative(volts[channel : channel + 1], shot.rate_hz)[0]
        return volts

    return _at_digitiser(work, samples, shot)


def _low_pass_all(look: Look) -> Array:
    """A delay common to all channels is a phase of the motion: the droop, of second order, is what is seen.

    The strength is tau^2 with the sign of tau; the model's own equation gives the second derivative.
    """
    return np.gradient(look.slope, look.time_s, axis=1, edge_order=2)[None]


def _undo_low_pass_all(samples: Array, shot: Shot, strength: float) -> Array:
    """As for one channel."""
    tau = math.copysign(math.sqrt(abs(strength)), strength)
    return np.asarray(samples + tau * derivative(samples, shot.rate_hz))


def _root(strength: float, sd: float, _: float, __: float) -> tuple[float, float]:
    """A time constant from its square."""
    tau = math.sqrt(abs(strength))
    return math.copysign(tau, strength), sd / max(2.0 * tau, math.sqrt(sd))


def _compression(channel: int, look: Look) -> Array:
    return _on(look, channel, -(look.volts[channel] ** 3))


def _compression_all(look: Look) -> Array:
    return _in(look, -(look.volts**3))


def _expanded(volts: Array, strength: float) -> Array:
    """u from u (1 - c u^2), by iteration."""
    u = volts
    for _ in range(4):
        u = volts + strength * u**3
    return u


def _undo_compression(channel: int, samples: Array, shot: Shot, strength: float) -> Array:
    def work(volts: Array) -> Array:
        volts[channel] = _expanded(volts[channel], strength)
        return volts

    return _at_digitiser(work, samples, shot)


def _undo_compression_all(samples: Array, shot: Shot, strength: float) -> Array:
    return _at_digitiser(lambda volts: _expanded(volts, strength), samples, shot)


def _mix(source: int, target: int, look: Look) -> Array:
    return _on(look, target, look.volts[source])


def _undo_mix(source: int, target: int, samples: Array, shot: Shot, strength: float) -> Array:
    def work(volts: Array) -> Array:
        volts[target] -= strength * volts[source]
        return volts

    return _at_digitiser(work, samples, shot)
