"""From the fits of a noise sweep to the curves of fig:noise_plot, their prediction, and where they cross."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from platform_daemon.estimation.cramer_rao import MeasurementPlan, predict_precision
from platform_daemon.estimation.parameters import RODRIGUES
from platform_daemon.estimation.thresholds import THRESHOLDS
from platform_daemon.features.characterise.dataset import shot_values
from platform_daemon.features.characterise.schema import CharacterisationReport
from platform_daemon.features.fit.batch.part import InputFile
from platform_daemon.features.fit.series.orientation import error_angle

from .noise_fits import added_sd, own_noise
from .noise_parts import NoiseSweep
from .noise_schema import BreakEven, NoiseCurve, NoisePart, NoisePoint, NoiseSweepReport

_BOOTSTRAP = 300  # resamples of the shots: 2.5 % of them are 7
_PREDICTED = 2000  # drawn orientations: the median is known to 3 %
_MEDIAN_OF_NORMAL = 0.6744897501960817  # median of |x| of a standard normal x
_ENDS = (2.5, 97.5)
_WITHOUT = 0.05  # share of resamples without a crossing from which on there is no interval
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Fits:
    """Of one specimen, (shots, levels, draws); nan: the fit failed."""

    f_nat_hz: Floats
    error_rad: Floats

    def resampled(self, rng: np.random.Generator) -> NDArray[np.intp]:
        """As many shots, some twice and some not."""
        n = self.f_nat_hz.shape[0]
        return np.asarray(rng.choice(n, size=n), dtype=np.intp)

    def curves(self, shots: NDArray[np.intp]) -> tuple[Floats, Floats]:
        """(MAD of f_nat, median error), each (levels,), of these shots; inf where more than half of the fits failed."""
        f, error = (np.swapaxes(x[shots], 0, 1).reshape(x.shape[1], -1) for x in (self.f_nat_hz, self.error_rad))
        middle = np.array([np.median(row[np.isfinite(row)]) if np.isfinite(row).any() else 0.0 for row in f])
        away = np.abs(f - middle[:, None])
        return tuple(np.median(np.where(np.isnan(x), np.inf, x), axis=1) for x in (away, error))  # type: ignore[return-value]


def noise_report(
    sweep: NoiseSweep, parts: Sequence[NoisePart], reports: Sequence[CharacterisationReport]
) -> NoiseSweepReport:
    """The curves of each specimen, and where the second becomes more precise than the first.

    Raises PlatformError for a recording that can no longer be read.
    """
    rng = np.random.default_rng(sweep.seed)
    fits = [_fits_of(k, sweep, parts, report) for k, report in enumerate(reports)]
    resampled = [[found.curves(found.resampled(rng)) for _ in range(_BOOTSTRAP)] for found in fits]
    whole = [found.curves(np.arange(found.f_nat_hz.shape[0])) for found in fits]
    curves = tuple(_curve(sweep, k, reports[k], fits[k], whole[k], resampled[k], rng) for k in range(len(reports)))
    crossings = (
        tuple(
            _break_even(sweep.levels, name, [w[q] for w in whole], [[one[q] for one in each] for each in resampled])
            for q, name in enumerate(("f_nat_hz", "orientation"))
        )
        if len(reports) == 2
        else ()
    )
    return NoiseSweepReport(draws=sweep.draws, seed=sweep.seed, curves=curves, break_even=crossings)


def _fits_of(specimen: int, sweep: NoiseSweep, parts: Sequence[NoisePart], report: CharacterisationReport) -> _Fits:
    frames = sweep.specimens[specimen][1].frames or ()
    place = {frame: k for k, frame in enumerate(frames)}
    shape = len(frames), len(sweep.levels), sweep.draws
    f, error, made = np.full(shape, np.nan), np.full(shape, np.nan), np.zeros(shape[:2], dtype=int)
    assert report.orientation_reference is not None
    reference = np.array(report.orientation_reference.rodrigues_rad)
    for fit in (fit for part in parts if part.specimen == specimen for fit in part.fits):
        at = place[fit.frame], fit.level
        if fit.f_nat_hz is not None and fit.rodrigues_rad is not None:
            f[(*at, made[at])] = fit.f_nat_hz
            error[(*at, made[at])] = float(error_angle(np.array(fit.rodrigues_rad), reference))
        made[at] += 1
    return _Fits(f, error)


def _curve(
    sweep: NoiseSweep,
    specimen: int,
    report: CharacterisationReport,
    fits: _Fits,
    whole: tuple[Floats, Floats],
    resampled: Sequence[tuple[Floats, Floats]],
    rng: np.random.Generator,
) -> NoiseCurve:
    path, settings = sweep.specimens[specimen]
    own, rate_hz = own_noise(InputFile(path), settings)
    predicted = _Prediction(report, own, rate_hz, settings.fixed or {}, rng)
    ends = [np.percentile([one[q] for one in resampled], _ENDS, axis=0, method="nearest") for q in (0, 1)]
    points = []
    for k, level in enumerate(sweep.levels):
        f_hz, error_rad = predicted.at(level)
        points.append(
            NoisePoint(
                level_am2_per_s=level,
                fits=fits.f_nat_hz.shape[0] * sweep.draws,
                failed=int(np.isnan(fits.f_nat_hz[:, k]).sum()),
                f_nat_mad_hz=_known(whole[0][k]),
                f_nat_mad_interval_hz=_interval(ends[0][:, k]),
                f_nat_mad_predicted_hz=f_hz,
                orientation_median_rad=_known(whole[1][k]),
                orientation_interval_rad=_interval(ends[1][:, k]),
                orientation_predicted_rad=error_rad,
            )
        )
    return NoiseCurve(
        specimen=path.name,
        variant=report.variant,
        own_level_am2_per_s=float(np.mean(own)),
        points=tuple(points),
    )


def _known(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _interval(ends: Floats) -> tuple[float, float] | None:
    return (float(ends[0]), float(ends[1])) if np.isfinite(ends).all() else None


class _Prediction:
    """Cramer-Rao bound of the added noise, and the recorded shots' scatter beyond that of their own noise."""

    def __init__(
        self,
        report: CharacterisationReport,
        own: Floats,
        rate_hz: float,
        held: dict[str, float],
        rng: np.random.Generator,
    ) -> None:
        assert report.orientation_reference is not None
        self._reference = np.array(report.orientation_reference.rodrigues_rad)
        short, _ = shot_values((report.n50_fits, report.d30_fits), report.orientation_reference)
        rows = list(short.parameters.values())
        names = ("f_nat_hz", *RODRIGUES)
        values = np.array([[row[name] for name in names] for row in rows])
        middle = {name: float(np.median([row[name] for row in rows])) for name in rows[0]}
        self._plan = MeasurementPlan(report.variant, middle | held, own.tolist(), rate_hz, tuple(held))
        self._own, self._names, self._mean, self._rng = own, names, values.mean(axis=0), rng
        scatter = np.cov(values.T) - self._bound(own)
        size, along = np.linalg.eigh(scatter)
        self._scatter = (along * np.maximum(size, 0.0)) @ along.T

    def _bound(self, sd: Floats) -> Floats:
        """Covariance of f_nat and the rotation vector, (4, 4)."""
        plan = MeasurementPlan(
            self._plan.variant, self._plan.parameters, sd.tolist(), self._plan.sampling_rate_hz, self._plan.fixed
        )
        found = predict_precision(plan, THRESHOLDS.screening.n50_s)
        places = [found.names.index(name) for name in self._names]
        return found.covariance[np.ix_(places, places)]

    def at(self, level: float) -> tuple[float, float]:
        """(MAD of f_nat in Hz, median orientation error in rad)."""
        covariance = self._scatter + self._bound(np.hypot(self._own, added_sd(self._own, level)))
        drawn = self._rng.multivariate_normal(self._mean, covariance, size=_PREDICTED)
        error = error_angle(drawn[:, 1:], self._reference)
        return _MEDIAN_OF_NORMAL * math.sqrt(covariance[0, 0]), float(np.median(error))


def _break_even(
    levels: Sequence[float], quantity: str, whole: Sequence[Floats], resampled: Sequence[Sequence[Floats]]
) -> BreakEven:
    found = _crossing(levels, *whole)
    if isinstance(found, str):
        return BreakEven(quantity=quantity, level_am2_per_s=None, interval_am2_per_s=None, reason=found)
    drawn = [_crossing(levels, one, other) for one, other in zip(*resampled, strict=True)]
    known = [level for level in drawn if isinstance(level, float)]
    ends = np.percentile(known, _ENDS) if len(known) >= (1.0 - _WITHOUT) * len(drawn) else np.full(2, np.inf)
    return BreakEven(quantity=quantity, level_am2_per_s=found, interval_am2_per_s=_interval(ends), reason=None)


def _crossing(levels: Sequence[float], first: Floats, second: Floats) -> float | str:
    """The level from which on the second is smaller at every higher one, between two levels by logarithms."""
    better = second < first
    if better.all():
        return "the second is more precise at every level"
    if not better[-1]:
        return "the second is not more precise at the highest level"
    k = int(np.flatnonzero(~better)[-1])
    with np.errstate(divide="ignore", invalid="ignore"):
        low, high = np.log(second[k : k + 2] / first[k : k + 2])
    share = low / (low - high) if math.isfinite(low) and math.isfinite(high) else 0.5
    return float(math.exp((1.0 - share) * math.log(levels[k]) + share * math.log(levels[k + 1])))
