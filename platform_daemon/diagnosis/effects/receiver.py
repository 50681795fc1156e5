"""Receiver effects act on the whole signal: gains, delays, poles, crosstalk, compression.

They act on the digitiser's channels; where calibration mixes these into dm/dt, so does the change. It is computed from
the model's signal, never from the data, whose noise would change with it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from platform_daemon.diagnosis.shots.linearisation import Linearisation
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array

from .effect import Candidate, Change, Detail, Effect, Public, unchanged

_LIMITS = THRESHOLDS.effects
AXES = "xyz"
_CAL_2F, _TURN, _AMPLITUDE = "calibrate_2f", "turn_90_deg", "second_amplitude"
GAIN = Effect(
    id="channel_gain",
    unit="1",
    sign=0,
    separates=(_TURN, _CAL_2F),
    signature="v3 in N50, u2 in D30; changes sign if turned by 90 degrees",
    source="calibration error; pole of a coil or an AC coupling",
    absorbed="a gain common to all channels is part of m_r",
)
DELAY = Effect(
    id="channel_delay",
    unit="s",
    sign=0,
    separates=(_CAL_2F, _TURN),
    signature="u2 in phase, the same in every window",
    source="filters that differ",
    absorbed="a delay common to all channels is part of psi_start",
)
LOW_PASS = Effect(
    id="receive_lowpass",
    unit="s",
    sign=1,
    separates=(_CAL_2F, _TURN),
    signature="u2 in phase; all channels: u2 and v3 in amplitude",
    source="capacitance of coil and cable, bandwidth of the amplifier",
    absorbed="the delay of a pole common to all channels is part of psi_start",
)
COMPRESSION = Effect(
    id="receiver_compression",
    unit="1/V^2",
    sign=0,
    separates=(_AMPLITUDE,),
    signature="v3 and v1 grow as phi^3",
    source="amplifier near its limit",
)
CROSSTALK = Effect(
    id="crosstalk",
    unit="1",
    sign=0,
    separates=(_TURN, _CAL_2F),
    signature="v2 in phase",
    source="coupling of coils, cables and channels",
    absorbed="the antisymmetric part of a crosstalk is part of the orientation R",
)

_LARGEST = {"1": _LIMITS.largest_gain, "s": _LIMITS.largest_delay_s}
_ORDERS = range(1, _LIMITS.pole_orders + 1)
_SHIFT = [(-1.0) ** n / math.factorial(n) for n in _ORDERS]
_POLE = [(-1.0) ** n for n in _ORDERS]
_POLE_WITHOUT_DELAY = [sum((-1.0) ** (n - k) / math.factorial(k) for k in range(n + 1)) for n in _ORDERS]


def receiver_candidates(channels: int, quantity: str, f_hz: float) -> list[Candidate]:
    """Receiver candidates that are visible in this number of channels of a quantity.

    f_hz: natural frequency, for gains of single harmonics.
    """
    if quantity == "angle":
        return [_single(GAIN, 0, None, _gain)]
    if quantity == "voltage":
        return _candidates_of_volts(channels)
    found = [_single(GAIN, c, AXES[c], _gain) for c in range(channels)]
    found += _delays_and_poles(AXES[:channels])
    found += _compressions(AXES[:channels])
    found += [
        _candidate(CROSSTALK, Detail(start=AXES[a], end=AXES[b]), partial(_mix, a, b))
        for a in range(channels)
        for b in range(channels)
        if a != b
    ]
    harmonics = [(f_hz, False), (2.0 * f_hz, True)]
    found += [
        _candidate(GAIN, Detail(axis=None if c is None else AXES[c], frequency_hz=f), partial(_band_gain, c, even))
        for f, even in harmonics
        for c in [*range(channels), None]
    ]
    return found


def _candidates_of_volts(channels: int) -> list[Candidate]:
    """Candidates for volts, where each coil has free sensitivities to odd and even harmonics: no gains, no crosstalk.

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


def _candidate(effect: Effect, detail: Detail, change: Change, public: Public = unchanged) -> Candidate:
    largest = _LARGEST.get(effect.unit, math.inf)
    return Candidate(effect, detail, columns=partial(_column, change), change=change, public=public, largest=largest)


def _column(change: Change, linearisation: Linearisation) -> Array:
    """The first-order change per unit of strength, (1, channels, m)."""
    return change(linearisation, _LIMITS.null_strength)[None] / _LIMITS.null_strength


def _in(linearisation: Linearisation, changes: Array) -> Array:
    """Changes (channels, m) at the digitiser as changes of the record's channels."""
    return np.asarray(linearisation.prepared.shot.from_volts @ changes)


def _on(linearisation: Linearisation, channel: int, row: Array) -> Array:
    """A change of one channel of the digitiser."""
    changes = np.zeros_like(linearisation.volts)
    changes[channel] = row
    return _in(linearisation, changes)


def _gain(channel: int, linearisation: Linearisation, strength: float) -> Array:
    return _on(linearisation, channel, strength * linearisation.volts[channel])


def _delay(channel: int, linearisation: Linearisation, strength: float) -> Array:
    return _on(linearisation, channel, _series(linearisation, _SHIFT, strength)[channel])


def _low_pass(channel: int, linearisation: Linearisation, strength: float) -> Array:
    return _on(linearisation, channel, _series(linearisation, _POLE, strength)[channel])


def _low_pass_all(linearisation: Linearisation, strength: float) -> Array:
    """A pole common to all channels, without its delay, which is a phase of the motion: an effect of second order.

    The strength is tau^2 with the sign of tau.
    """
    tau = math.copysign(math.sqrt(abs(strength)), strength)
    return _in(linearisation, _series(linearisation, _POLE_WITHOUT_DELAY, tau))


def _series(linearisation: Linearisation, coefficients: Sequence[float], tau: float) -> Array:
    """Change of the channels at the digitiser by sum over n of c_n (tau d/dt)^n, n = 1, 2 ...; (channels, m).

    Where friction changes sign the motion has a kink, whose high derivatives grow: the sum ends at its smallest term.
    """
    # The column of an effect is its first order.
    most = len(coefficients) if abs(tau) > math.sqrt(_LIMITS.null_strength) else 2
    out, smallest = np.zeros_like(linearisation.volts), math.inf
    for n, c in enumerate(coefficients[:most], start=1):
        if c != 0.0:
            term = c * tau**n * linearisation.derivative_v(n)
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


def _compression(channel: int, linearisation: Linearisation, strength: float) -> Array:
    return _on(linearisation, channel, -strength * linearisation.volts[channel] ** 3)


def _compression_all(linearisation: Linearisation, strength: float) -> Array:
    return _in(linearisation, -strength * linearisation.volts**3)


def _mix(source: int, target: int, linearisation: Linearisation, strength: float) -> Array:
    return _on(linearisation, target, strength * linearisation.volts[source])


def _band_gain(channel: int | None, even: bool, linearisation: Linearisation, strength: float) -> Array:
    """Of the odd or the even harmonics only, as a pole that lies between them makes it."""
    part = linearisation.prepared.shot.to_volts @ (linearisation.even if even else linearisation.odd)
    return (
        _in(linearisation, strength * part)
        if channel is None
        else _on(linearisation, channel, strength * part[channel])
    )
