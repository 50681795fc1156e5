"""Allan deviation of f_nat over a series: how long averaging helps, and what drifts.

Overlapping estimator; confidence from chi^2 with the equivalent degrees of freedom of the noise type found at each
averaging time (W. J. Riley, Handbook of Frequency Stability Analysis, NIST SP 1065, sections 5.2.4, 5.4, 5.5.6).
Every frame counts as the mean over its cadence. A frame measures for less than that, so for anything but white noise
the dead time biases the result a little (the handbook's B2 and B3).

allantools 2024.6 gives the same deviations, but n - 2 times too few degrees of freedom for flicker noise at the first
averaging time, and it names no noise below 30 averages.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.special import chdtri  # quantiles of chi^2; all of scipy.stats takes half a second to load

from platform_daemon.core.schemas.derived import AllanReport, FrequencyNoise
from platform_daemon.estimation.numerics.arrays import Array

_FEWEST = 4
_IRREGULAR = 0.1  # of the cadence
_ENOUGH_AVERAGES = 30  # for identifying the noise type
_NOISE_NAMES: dict[int, FrequencyNoise] = {
    2: "white_phase",
    1: "flicker_phase",
    0: "white",
    -1: "flicker",
    -2: "random_walk",
}


def allan_deviation(time_s: Array, frequency_hz: Array, confidence: float = 0.683) -> AllanReport:
    """Allan deviation of a series of frequencies (frames,) at regular times (frames,).

    Raises:
        ValueError: fewer than four frames, values that are not finite, times that do not rise, or a gap. Refused
            frames leave gaps: cut the series there, or fill them knowingly.
    """
    y = np.asarray(frequency_hz, dtype=np.float64)
    cadence = _cadence(np.asarray(time_s, dtype=np.float64), y)
    factors = 2 ** np.arange(int(math.log2((y.size - 1) / 2)) + 1)
    deviation = np.array([_deviation(y, int(m)) for m in factors])
    exponents = _exponents(y, factors)
    edf = np.array([_edf(a, int(m), y.size + 1) for a, m in zip(exponents, factors, strict=True)])
    tail = 0.5 * (1.0 - confidence)
    slope, slope_sd = _slope(factors, deviation, edf)
    return AllanReport(
        tau_s=tuple((factors * cadence).tolist()),
        deviation_hz=tuple(deviation.tolist()),
        low_hz=tuple((deviation * np.sqrt(edf / chdtri(edf, tail))).tolist()),
        high_hz=tuple((deviation * np.sqrt(edf / chdtri(edf, 1.0 - tail))).tolist()),
        noise=tuple(_NOISE_NAMES[a] for a in exponents),
        slope=slope,
        slope_std=slope_sd,
        mean_hz=float(y.mean()),
        cadence_s=cadence,
    )


def _cadence(time: Array, y: Array) -> float:
    """The regular interval between frames, s."""
    if y.ndim != 1 or time.shape != y.shape or y.size < _FEWEST:
        raise ValueError(f"an Allan deviation needs at least {_FEWEST} frames with a time each, not {y.shape}")
    if not (np.all(np.isfinite(y)) and np.all(np.isfinite(time))):
        raise ValueError("an Allan deviation needs finite frequencies and times: a refused frame is a gap")
    steps = np.diff(time)
    cadence = float(np.median(steps))
    if not np.all(steps > 0.0):
        raise ValueError("the times of the frames do not rise")
    off = np.flatnonzero(np.abs(steps - cadence) > _IRREGULAR * cadence)
    if off.size:
        where = ", ".join(f"{steps[k]:.4g} s after frame {k}" for k in off[:3])
        raise ValueError(f"{off.size} gaps in a cadence of {cadence:.4g} s: {where}")
    return float(time[-1] - time[0]) / (y.size - 1)


def _deviation(y: Array, m: int) -> float:
    """Overlapping Allan deviation for averages of m frames."""
    phase = np.concatenate([[0.0], np.cumsum(y - y.mean())])
    second = phase[2 * m :] - 2.0 * phase[m:-m] + phase[: -2 * m]
    return float(np.sqrt(np.mean(second**2) / 2.0) / m)


def _exponents(y: Array, factors: np.ndarray) -> list[int]:
    """Exponent of the frequency noise's power law per averaging factor; the last certain one where averages are few."""
    found: list[int] = []
    for m in factors:
        averages = y[: y.size // m * m].reshape(-1, m).mean(axis=1)
        if averages.size >= _ENOUGH_AVERAGES or not found:
            found.append(_exponent(averages))
        else:
            found.append(found[-1])
    return found


def _exponent(averages: Array) -> int:
    """Lag-1 autocorrelation r of the averages, differenced until stationary: alpha = -2 r/(1 + r) - 2 d."""
    for differences in range(3):
        z = averages - averages.mean()
        power = float(z @ z)
        r = float(z[1:] @ z[:-1]) / power if power > 0.0 else 0.0
        delta = r / (1.0 + r)
        if delta < 0.25 or differences == 2 or averages.size < _FEWEST:
            break
        averages = np.diff(averages)
    return int(np.clip(round(-2.0 * (delta + differences)), -2, 2))


def _edf(alpha: int, m: int, n: int) -> float:
    """Equivalent degrees of freedom for n phase points (Table 5 of the handbook); at least 1."""
    if alpha == 2:
        edf = (n + 1) * (n - 2 * m) / (2.0 * (n - m))
    elif alpha == 1:
        edf = math.exp(math.sqrt(math.log((n - 1) / (2.0 * m)) * math.log((2 * m + 1) * (n - 1) / 4.0)))
    elif alpha == 0:
        edf = (3.0 * (n - 1) / (2.0 * m) - 2.0 * (n - 2) / n) * 4.0 * m * m / (4.0 * m * m + 5.0)
    elif alpha == -1:
        edf = 2.0 * (n - 2) / (2.3 * n - 4.9) * (n - 2) if m == 1 else 5.0 * n * n / (4.0 * m * (n + 3.0 * m))
    else:
        edf = (n - 2) / m * ((n - 1) ** 2 - 3.0 * m * (n - 1) + 4.0 * m * m) / (n - 3.0) ** 2
    return max(edf, 1.0)


def _slope(factors: np.ndarray, deviation: Array, edf: Array) -> tuple[float | None, float | None]:
    """Slope of log deviation over log tau and its sd, None where a deviation is zero or alone.

    A deviation's logarithm has the variance 1/(2 edf); the averaging times are taken for independent, which overlap
    makes them not quite.
    """
    if np.any(deviation <= 0.0) or factors.size < 2:
        return None, None
    x = np.log(factors)
    weight = 2.0 * edf
    centred = x - np.average(x, weights=weight)
    information = float(np.sum(weight * centred**2))
    return float(np.sum(weight * centred * np.log(deviation)) / information), information**-0.5
