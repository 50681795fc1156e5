"""Receiver effects act on the whole signal: gains, delays, poles, crosstalk, compression.

They act on the digitiser's channels; where calibration mixes these into dm/dt, so does the change. It is computed from
the model's signal, never from the data, whose noise would change with it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from platform_daemon.estimation import Array

from ..shots.linearisation import Linearisation
from .effect import Candidate, Change, Detail, Effect, Public, as_it_is

AXES = "xyz"
_SMALL = 1e-12  # a strength whose square is nothing
_CAL_2F, _TURN, _AMPLITUDE = "calibrate_2f", "turn_90_deg", "second_amplitude"
GAIN = Effect(
    "channel_gain", "1", 0, (_TURN, _CAL_2F), "v3 in N50, u2 in D30; changes sign if turned by 90 degrees",
    "calibration error; pole of a coil or an AC coupling", "a gain common to all channels is part of m_r",)  # fmt: skip
DELAY = Effect(
    "channel_delay",
    "s",
    0,
    (_CAL_2F, _TURN),
    "u2 in phase, the same in every window",
    "filters that differ",
    "a delay common to all channels is part of psi_start",
)
LOW_PASS = Effect(
    "receive_lowpass", "s", 1, (_CAL_2F, _TURN), "u2 in phase; all channels: u2 and v3 in amplitude",
    "capacitance of coil and cable, bandwidth of the amplifier",
    "the delay of a pole common to all channels is part of psi_start",
)  # fmt: skip
COMPRESSION = Effect(
    "receiver_compression", "1/V^2", 0, (_AMPLITUDE,), "v3 and v1 grow as phi^3", "amplifier near its limit",
)  # fmt: skip
CROSSTALK = Effect(
    "crosstalk",
    "1",
    0,
    (_TURN, _CAL_2F),
    "v2 in phase",
    "coupling of coils, cables and channels",
    "the antisymmetric part of a crosstalk is part of the orientation R",
)

_LARGEST = {"1": 0.3, "s": 1e-3}
_ORDERS = range(1, 9)  # of tau d/dt, for time constants up to a third of the second harmonic's
_SHIFT = [(-1.0) ** n / math.factorial(n) for n in _ORDERS]
_POLE = [(-1.0) ** n for n in _ORDERS]
_POLE_WITHOUT_DELAY = [sum((-1.0) ** (n - k) / math.factorial(k) for k in range(n + 1)) for n in _ORDERS]


def receiver_candidates(channels: int, quantity: str, f_hz: float) -> list[Candidate]:
    """Everything that can happen to so many channels and be seen there.

    f_hz: natural frequency, for gains of single harmonics.
    """
    if quantity == "angle":
        return [_single(GAIN, 0, None, _gain)]
    if quantity == "voltage":
        return _beside_free_gains(channels)
    found = [_single(GAIN, c, AXES[c], _gain) for c in range(channels)]
    found += _delays_and_poles(AXES[:channels])
    found += _compressions(AXES[:channels])
    found += [
        _candidate(CROSSTALK, Detail(start=AXES[a], end=AXES[b]), partial(_mix, a, b))
        for a in range(channels) for b in range(channels) if a != b
    ]  # fmt: skip
    harmonics = [(f_hz, False), (2.0 * f_hz, True)]
    found += [
        _candidate(GAIN, Detail(axis=None if c is None else AXES[c], frequency_hz=f), partial(_band_gain, c, even))
        for f, even in harmonics for c in [*range(channels), None]
    ]  # fmt: skip
    return found


def _beside_free_gains(channels: int) -> list[Candidate]:
    """What volts show whose coils have free sensitivities to odd and to even harmonics: no gain, no mixing.

    Coils without a calibration have no axes, and what acts on the only one acts on all.
    """
    names = [f"channel {c}" for c in range(channels)]
    if channels == 1:
        return [
            _candidate(LOW_PASS, Detail(), _low_pass_all, _root),
            _candidate(COMPRESSION, Detail(), _compression_all),
        ]
    return [*_delays_and_poles(names), *_compressions(names)]


def _delays_and_poles(names: Sequence[str]) -> list[Candidate]:
    found = [_single(DELAY, c, name, _delay) for c, name in enumerate(names)]
    found += [_single(LOW_PASS, c, name, _low_pass) for c, name in enumerate(names)]
    return [*found, _candidate(LOW_PASS, Detail(), _low_pass_all, _root)]


def _compressions(names: Sequence[str]) -> list[Candidate]:
    found = [_single(COMPRESSION, c, name, _compression) for c, name in enumerate(names)]
    return [*found, _candidate(COMPRESSION, Detail(), _compression_all)]


def _single(
    effect: Effect, channel: int, name: str | None, change: Callable[[int, Linearisation, float], Array]
) -> Candidate:
    """An effect of one channel."""
    return _candidate(effect, Detail(axis=name), partial(change, channel))


def _candidate(effect: Effect, detail: Detail, change: Change, public: Public = as_it_is) -> Candidate:
    largest = _LARGEST.get(effect.unit, math.inf)
    return Candidate(effect, detail, columns=partial(_column, change), change=change, public=public, largest=largest)


def _column(change: Change, look: Linearisation) -> Array:
    """The first-order change per unit of strength, (1, channels, m)."""
    return change(look, _SMALL)[None] / _SMALL


def _in(look: Linearisation, changes: Array) -> Array:
    """Changes (channels, m) at the digitiser as changes of the record's channels."""
    return np.asarray(look.started.shot.from_volts @ changes)


def _on(look: Linearisation, channel: int, row: Array) -> Array:
    """A change of one channel of the digitiser."""
    changes = np.zeros_like(look.volts)
    changes[channel] = row
    return _in(look, changes)


def _gain(channel: int, look: Linearisation, strength: float) -> Array:
    return _on(look, channel, strength * look.volts[channel])


def _delay(channel: int, look: Linearisation, strength: float) -> Array:
    return _on(look, channel, _series(look, _SHIFT, strength)[channel])


def _low_pass(channel: int, look: Linearisation, strength: float) -> Array:
    return _on(look, channel, _series(look, _POLE, strength)[channel])


def _low_pass_all(look: Linearisation, strength: float) -> Array:
    """A delay common to all channels is a phase of the motion: what is seen is the rest, of second order.

    The strength is tau^2 with the sign of tau.
    """
    tau = math.copysign(math.sqrt(abs(strength)), strength)
    return _in(look, _series(look, _POLE_WITHOUT_DELAY, tau))


def _series(look: Linearisation, coefficients: Sequence[float], tau: float) -> Array:
    """Change of the channels at the digitiser by sum over n of c_n (tau d/dt)^n, n = 1, 2 ...; (channels, m).

    Where friction changes sign the motion has a kink, whose high derivatives grow: the sum ends at its smallest term.
    """
    # The column of an effect is its first order.
    most = len(coefficients) if abs(tau) > math.sqrt(_SMALL) else 2
    out, smallest = np.zeros_like(look.volts), math.inf
    for n, c in enumerate(coefficients[:most], start=1):
        if c != 0.0:
            term = c * tau**n * look.derivative_v(n)
            size = float(np.vdot(term, term))
            if size > smallest:
                break
            out += term
            smallest = size
    return out


def _root(strength: float, sd: float, _: float) -> tuple[float, float]:
    """A time constant from its square."""
    tau = math.sqrt(abs(strength))
    return math.copysign(tau, strength), sd / max(2.0 * tau, math.sqrt(sd))


def _compression(channel: int, look: Linearisation, strength: float) -> Array:
    return _on(look, channel, -strength * look.volts[channel] ** 3)


def _compression_all(look: Linearisation, strength: float) -> Array:
    return _in(look, -strength * look.volts**3)


def _mix(source: int, target: int, look: Linearisation, strength: float) -> Array:
    return _on(look, target, strength * look.volts[source])


def _band_gain(channel: int | None, even: bool, look: Linearisation, strength: float) -> Array:
    """Of the odd or the even harmonics only, as a pole that lies between them makes it."""
    part = look.started.shot.to_volts @ (look.even if even else look.odd)
    return _in(look, strength * part) if channel is None else _on(look, channel, strength * part[channel])
