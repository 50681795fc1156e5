"""Which effect, how strong it may be, and how it is drawn for record number k of a seed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

SIGMAS = (15.0, 50.0, 200.0, 1000.0)
RATES_HZ = (100.0, 200.0, 500.0, 1000.0, 2000.0, 5000.0, 10000.0)
_FEWEST_PERIODS, _SAMPLES_OF_A_PERIOD = 6.0, 12.0
FRICTION, CUBIC = "coulomb_friction", "restoring_anharmonicity"


@dataclass(frozen=True)
class Case:
    """One row of the study.

    Attributes:
        name: as --only has it.
        effects: names by the product's list; all of them are to be named.
        optional: names that are right beside them, and not missed.
        strengths: parameters of the motion that grow together with the visibility.
        kept: effects of the truth that the best fit without the effect may use, for each way to leave one out.
        outside: the effect is in no library; right is what names nothing and does not say that
            nothing is missing.
        gaps: samples are lost. stuck: it comes to rest. shape: further parameters of the effect.
    """

    name: str
    effects: tuple[str, ...] = ()
    optional: tuple[str, ...] = ()
    strengths: tuple[str, ...] = ()
    kept: tuple[tuple[str, ...], ...] = ((),)
    outside: bool = False
    gaps: bool = False
    stuck: bool = False
    shape: tuple[str, ...] = ()


CASES = (
    Case("coulomb", (FRICTION,), strengths=("coulomb",)),
    Case("viscous"),
    Case("quadratic", ("quadratic_drag",), strengths=("quadratic",)),
    Case("gap", ("clock_gap",), gaps=True),
    Case("angle-damping", ("angle_dependent_damping",), strengths=("angle_damping",)),
    Case(
        "stribeck", ("stribeck_friction",), (FRICTION,), ("coulomb",), (("coulomb",),), shape=("excess", "speed"),
    ),
    Case("gap+coulomb", ("clock_gap", FRICTION), strengths=("coulomb",), gaps=True),
    Case("cubic", (CUBIC,), strengths=("cubic",)),
    Case("bias", ("bias_torque",), strengths=("bias",)),
    Case("drift", ("frequency_drift",), strengths=("drift",)),
    Case(
        "coulomb+quadratic", (FRICTION, "quadratic_drag"), (), ("coulomb", "quadratic"),
        (("coulomb",), ("quadratic",)),
    ),
    Case("drift-exponential", ("frequency_drift",), strengths=("drift",), shape=("drift_tau",)),
    Case("kick", ("kick",), strengths=("kick",), shape=("kick_s",)),
    Case("zero-drift", strengths=("zero",), outside=True, shape=("zero_tau",)),
    Case("second-mode", ("side_mode",), strengths=("mode_cos", "mode_sin"), shape=("mode_hz", "mode_tau")),
    Case("stuck", (FRICTION,), ("stribeck_friction",), ("coulomb",), stuck=True),
)  # fmt: skip
ALSO_CALLED = {
    CUBIC: {CUBIC, "torsion_stiffness", "cubic_restoring"},
    "frequency_drift": {"frequency_drift", "frequency_drift_exponential", "exponential_drift"},
}
"""Names that stand for the same truth: the cubic part of a restoring torque has several."""


@dataclass(frozen=True)
class Draw:
    """What record k of a seed is to be, before its strength is found.

    full: amplitude and width of the reading; quantum_rad, white_rad: of the noise. gaps: (first sample lost, how many)
    of the motion's own samples.
    """

    seed: int
    index: int
    again: int
    case: Case
    sigma: float
    duration_s: float
    rate_hz: float
    bits: int
    quantum_rad: float
    white_rad: float
    amplitude: float
    motion: dict[str, float]
    largest: dict[str, float]
    gaps: tuple[tuple[int, int], ...]

    @property
    def sd(self) -> float:
        """Of a sample's error: white and of the quantum."""
        return math.hypot(self.white_rad, self.quantum_rad / math.sqrt(12.0))

    @property
    def samples(self) -> int:
        """Of the file."""
        return int(self.duration_s * self.rate_hz)


def drawn(seed: int, index: int, again: int = 0) -> Draw:
    """Record number `index` of this seed, or another of its kind."""
    case, sigma = CASES[index % len(CASES)], SIGMAS[(index // len(CASES)) % len(SIGMAS)]
    rng = np.random.default_rng([seed, index, again])
    long = bool(rng.random() < 0.6)
    duration = float(rng.uniform(100.0, 120.0)) if long else 5.0
    f_hz = _log_uniform(rng, max(0.5, _FEWEST_PERIODS / duration), 8.0)
    rates = [r for r in RATES_HZ if r >= _SAMPLES_OF_A_PERIOD * f_hz]
    rate = float(rng.choice(rates))
    amplitude = float(rng.uniform(0.3, 2.0))
    w = 2.0 * math.pi * f_hz * _slower(amplitude)
    bits = int(rng.integers(8, 17))
    reach = math.pi if rng.random() < 0.5 else 1.2 * amplitude
    quantum = 2.0 * reach / 2**bits
    fall = float(rng.uniform(0.3, 2.0))  # of ln(amplitude) over the record
    phi = amplitude * math.cos(turn := float(rng.uniform(0.0, 2.0 * math.pi)))
    speed = 2.0 * math.pi * f_hz * math.sqrt(2.0 * (math.cos(phi) - math.cos(amplitude)))
    motion = {
        "f_hz": f_hz,
        "lambda": fall / duration,
        "phi": phi,
        "v": -math.copysign(speed, math.sin(turn)),
        "offset": float(rng.uniform(-0.05, 0.05)) * amplitude,
    }
    motion |= {name: _SHAPES[name](rng, amplitude * w, duration, f_hz, rate) for name in case.shape}
    if "excess" in motion:
        motion["law"] = float(rng.integers(3))
    scale = _largest(amplitude, w, duration, fall)
    sign = 1.0 if rng.random() < 0.5 else -1.0
    largest = {n: scale[n] * (sign if n in _EITHER_SIGN else float(rng.uniform(0.5, 1.0))) for n in case.strengths}
    if case.stuck:
        largest["coulomb"] = _resting(amplitude, w, duration * float(rng.uniform(0.5, 0.85)), fall / duration)
    if "drift_tau" in motion:
        largest["drift"] *= duration
    if "excess" in motion:
        largest["coulomb"] /= 1.0 + motion["excess"]
    white = quantum * _log_uniform(rng, 0.1, 2.0)
    gaps = _gaps(rng, int(duration * rate)) if case.gaps else ()
    return Draw(
        seed, index, again, case, sigma, duration, rate, bits, quantum, white, amplitude, motion, largest, gaps
    )  # fmt: skip


_EITHER_SIGN = ("cubic", "bias", "drift", "kick", "zero", "mode_cos", "mode_sin")
_Shape = Callable[[np.random.Generator, float, float, float, float], float]  # peak speed, duration, f, rate
_SHAPES: dict[str, _Shape] = {
    "excess": lambda rng, peak, duration, f, rate: float(rng.uniform(0.3, 1.5)),
    "speed": lambda rng, peak, duration, f, rate: peak * _log_uniform(rng, 0.05, 0.5),
    "drift_tau": lambda rng, peak, duration, f, rate: duration * float(rng.uniform(0.1, 0.5)),
    "kick_s": lambda rng, peak, duration, f, rate: duration * float(rng.uniform(0.3, 0.6)),
    "zero_tau": lambda rng, peak, duration, f, rate: duration * float(rng.choice([0.0, 0.2, 0.5])),
    "mode_hz": lambda rng, peak, duration, f, rate: min(f * float(rng.choice([1.6, 2.4, 3.7, 4.5, 6.3])), 0.4 * rate),
    "mode_tau": lambda rng, peak, duration, f, rate: duration * float(rng.uniform(0.1, 0.4)),
}


def _log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))


def _slower(amplitude: float) -> float:
    """Frequency of a pendulum at this amplitude over that of small swings."""
    a, b = 1.0, math.cos(0.5 * amplitude)
    for _ in range(6):
        a, b = 0.5 * (a + b), math.sqrt(a * b)
    return a


def _resting(amplitude: float, w: float, rests_s: float, rate: float) -> float:
    """Dry friction that ends a viscous motion at about this time."""
    return 0.5 * math.pi * w * rate * amplitude / math.expm1(rate * rests_s)


def _largest(amplitude: float, w: float, duration: float, fall: float) -> dict[str, float]:
    """Strengths beyond which it would be another kind of record."""
    whole = math.exp(-fall)
    friction = 0.5 * math.pi * w * (fall / duration) * amplitude * max(whole - 0.08, 0.02) / (1.0 - whole)
    return {
        "coulomb": friction,
        "quadratic": 0.75 * math.pi * 2.0 / (w * amplitude * duration),
        "angle_damping": 16.0 / (amplitude**2 * duration),
        "cubic": 0.3 * math.sin(amplitude) / amplitude**3,
        "bias": 0.05 * w * w,
        "drift": 0.03 / duration,
        "kick": 0.2 * amplitude * w,
        "zero": 0.1 * amplitude,
        "mode_cos": 0.1 * amplitude,
        "mode_sin": 0.1 * amplitude,
    }


def _gaps(rng: np.random.Generator, samples: int) -> tuple[tuple[int, int], ...]:
    """One to three, well apart and within the middle of the record."""
    count = int(rng.integers(1, 4))
    places = [int(samples * (0.15 + 0.7 * (k + rng.uniform(0.1, 0.9)) / count)) for k in range(count)]
    return tuple((place, round(_log_uniform(rng, 1.0, 100.0))) for place in places)
