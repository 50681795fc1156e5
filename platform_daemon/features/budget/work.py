"""The budgets of a fit and of a series."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, date, datetime
from statistics import fmean

import numpy as np
from numpy.typing import NDArray

from drivers.calibration import ReceiveCalibration
from drivers.errors import InputError
from drivers.uncertainty import DeclaredUncertainty
from platform_daemon.core.schemas.fits import FrameFit
from platform_daemon.estimation.parameters import RODRIGUES
from platform_daemon.estimation.result import FitResult
from platform_daemon.features.fit.fit import fit_frame_of, frame_report
from platform_daemon.features.fit.fit_request import FitRefused, FitRequest
from platform_daemon.features.fit.known_moment import declared_specimen
from platform_daemon.features.fit.measurement import Measurement, VoltageMeasurement
from platform_daemon.features.fit.noise import noise_of_frames
from platform_daemon.features.fit.series_table import recorded_fits
from platform_daemon.uncertainty.budget import Budget, NotDeclared, checked_coverage, combine
from platform_daemon.uncertainty.cone import cone_angle
from platform_daemon.uncertainty.inputs import InputQuantity, correlation_matrix
from platform_daemon.uncertainty.monte_carlo import MonteCarloResult, monte_carlo

from .declared import check_coefficients, declared_in
from .influences import Effect, Situation, effects_of
from .off_centre import OffCentre, off_centre
from .response import response_of, turned_to_rodrigues
from .statistics import Statistics, add_model, differences, explained, scatter_of

Array = NDArray[np.float64]
_MODEL_SHOTS = 12
"""So many shots of a series, spread over it, are fitted with N50 too: what the two windows disagree by is the model's,
the same in all shots."""
_NOISE_OF = 4  # every fourth of them tells the noise: three ring-downs of a second have a million samples
_NEGLIGIBLE = 1e-6  # of the combined u: a line that is left out


@dataclass(frozen=True, eq=False)
class ResultBudgets:
    """Budgets of all parameters of one result.

    Attributes:
        budgets: in the order of the parameters; covariance: (m, m) of them, all influences included.
        rotation: (3, 3) covariance of a small rotation of the rotor's frame about the world axes, rad^2; cone_rad: half
            angle of a cone that contains a direction fixed to it, at the coverage; None: there is no orientation.
        frames: that the result is made of; temperature_c: their mean, temperature_change_k: by how much it changed over
            them, None: not measured.
        off_centre: of the one shot, or of that in the middle; None: not tested.
    """

    budgets: tuple[Budget, ...]
    covariance: Array
    rotation: Array | None
    cone_rad: float | None
    frames: tuple[int, ...]
    temperature_c: float | None
    temperature_change_k: float | None = None
    off_centre: OffCentre | None = None

    def of(self, quantity: str) -> Budget:
        """Of one parameter.  Raises InputError for a name that is none of them."""
        names = [each.quantity for each in self.budgets]
        if quantity not in names:
            raise InputError(f"the fit has no {quantity!r}", where="quantity", remedy=f"one of: {', '.join(names)}")
        return self.budgets[names.index(quantity)]


@dataclass(frozen=True, eq=False)
class BudgetParts:
    """What the budgets of a result are made of.

    Attributes:
        effects: of every influence; given: what they depend on; told: what the fits themselves say; frames: of these.
    """

    effects: tuple[Effect, ...]
    given: Situation
    told: Statistics
    frames: tuple[int, ...]

    def budgets(self, coverage: float, shots: int | None = None) -> ResultBudgets:
        """The budgets, or those of a mean over another number of shots that scatter alike."""
        told = self.told
        if shots is not None:
            told = replace(told, covariance=told.covariance * (len(self.frames) / shots))
        return budgets_by(self.effects, self.given, told, self.frames, coverage)


def shot_budgets(
    measurement: Measurement,
    frame: int,
    ask: FitRequest,
    *,
    fit: FitResult | None = None,
    declared: DeclaredUncertainty | None = None,
    coverage: float = 0.95,
) -> ResultBudgets:
    """The budgets of the fit of one frame.

    fit: of that frame, None: it is made; declared: in the place of what the recording says.  Raises InputError for a
    refused fit, a certificate that does not hold, or correlations that contradict each other.
    """
    checked_coverage(coverage)
    found = parts_of_shot(measurement, frame, ask, fit=fit, declared=declared)
    return replace(found.budgets(coverage), off_centre=off_centre(found.given, found.effects))


def parts_of_shot(
    measurement: Measurement,
    frame: int,
    ask: FitRequest,
    *,
    fit: FitResult | None = None,
    declared: DeclaredUncertainty | None = None,
) -> BudgetParts:
    """What the budgets of the fit of one frame are made of, as `shot_budgets` says."""
    used = fit or fit_frame_of(measurement, frame, ask)
    if used.verdict != "good":
        remedy = "name another shot"
        raise FitRefused("the fit was refused", where=f"frame {frame}", why=used.reason or "", remedy=remedy)
    if used.fitted is None:
        why = "influences are propagated through the model of one angle, which a manufacturing error does not obey"
        remedy = "take the std of the fit, or budget the declared model"
        raise InputError(f"{ask.label} cannot be used here", where="variant", why=why, remedy=remedy)
    names = tuple(used.parameters)
    short = fit_frame_of(measurement, frame, replace(ask, window="n50")) if ask.window == "d30" else None
    given = _situation(measurement, (frame,), frame, used, declared)
    effects = effects_of(given)
    difference = std = None
    if short is not None and short.verdict == "good":
        difference, std = differences(names, [frame_report(frame, used)], [frame_report(frame, short)])
        std = np.hypot(std, explained(effects, effects_of(_by_fit(given, short, measurement, frame))))
    own = np.zeros((len(names), len(names)))
    free = [names.index(name) for name in used.covariance_names]
    own[np.ix_(free, free)] = used.covariance
    values = np.array([each.value for each in used.parameters.values()])
    told = Statistics(names, values, own, "noise", "covariance of the fit", math.inf, difference, std)
    return BudgetParts(effects, given, told, (frame,))


def series_budgets(
    measurement: Measurement,
    ask: FitRequest,
    *,
    frames: Sequence[int] | None = None,
    declared: DeclaredUncertainty | None = None,
    coverage: float = 0.95,
) -> ResultBudgets:
    """The budgets of the mean over a series: scatter becomes less with every shot, what all shots share does not.

    frames: that are meant, None: all that can be used.  On-line fits that the recording keeps are taken, if they are of
    this request; else all are fitted.  Raises InputError for fewer than two good fits, and as
    `shot_budgets` does.
    """
    checked_coverage(coverage)
    found = parts_of_series(measurement, ask, frames=frames, declared=declared)
    return replace(found.budgets(coverage), off_centre=off_centre(found.given, found.effects))


def parts_of_series(
    measurement: Measurement,
    ask: FitRequest,
    *,
    frames: Sequence[int] | None = None,
    declared: DeclaredUncertainty | None = None,
) -> BudgetParts:
    """What the budgets of the mean over a series are made of, as `series_budgets` says."""
    usable = [k for k in (range(measurement.frames) if frames is None else frames) if measurement.excuse(k) is None]
    kept = recorded_fits(measurement, ask)
    if kept is None:
        made = {k: fit_frame_of(measurement, k, ask) for k in usable}
        reports = [frame_report(k, fit) for k, fit in made.items() if fit.verdict == "good"]
    else:
        made = {}
        reports = [kept[k] for k in usable if kept[k].good]
    good = _enough(measurement, reports)
    middle = good[len(good) // 2]
    looked_at = sorted({middle, *_spread(good)})
    if kept is not None:
        measurement = _with_noise_of(measurement, looked_at)
    used = made.get(middle) or _fitted_again(measurement, middle, ask)
    short: dict[int, FitResult] = {}
    if ask.window == "d30":
        short = {k: fit_frame_of(measurement, k, replace(ask, window="n50")) for k in looked_at}
        short = {k: fit for k, fit in short.items() if fit.verdict == "good"}
    reports_short = [frame_report(k, fit) for k, fit in short.items()]
    return _mean_of(measurement, reports, reports_short, middle, used, short.get(middle), declared)


def parts_of_fits(
    measurement: Measurement,
    ask: FitRequest,
    long: Sequence[FrameFit],
    short: Sequence[FrameFit],
    held: Mapping[str, float],
) -> BudgetParts:
    """What the budgets of the mean of good D30 fits are made of, which were made already.

    short: the good N50 fits of any of these frames, which hold `held`, SI; of such a parameter nobody can see whether
    the windows disagree.  Raises InputError for fewer than two good fits, and as `shot_budgets` does.
    """
    good = _enough(measurement, long)
    both = sorted({fit.frame for fit in short} & set(good))
    middle = (both or good)[len(both or good) // 2]
    measurement = _with_noise_of(measurement, [middle])
    used = _fitted_again(measurement, middle, ask)
    used_short = None
    if both:
        used_short = _fitted_again(measurement, middle, replace(ask, window="n50", fixed=dict(held) or None))
    taken = [fit for fit in short if fit.frame in both]
    return _mean_of(measurement, long, taken, middle, used, used_short, None)


def _enough(measurement: Measurement, reports: Sequence[FrameFit]) -> list[int]:
    """The frames.  Raises InputError for fewer than two."""
    good = [report.frame for report in reports]
    if len(good) < 2:
        what = f"{len(good)} of {measurement.frames} frames have a good fit, and a scatter needs two"
        raise InputError(what, where=str(measurement.path), remedy="ask for one shot, or record more")
    return good


def _spread(good: Sequence[int]) -> list[int]:
    """At most _MODEL_SHOTS of them, from the first to the last."""
    return sorted({good[k] for k in np.linspace(0, len(good) - 1, _MODEL_SHOTS).round().astype(int)})


def _with_noise_of(measurement: Measurement, frames: Sequence[int]) -> Measurement:
    if not isinstance(measurement, VoltageMeasurement):
        return measurement
    return replace(measurement, known_noise=noise_of_frames(measurement.recording, frames[::_NOISE_OF]))


def _fitted_again(measurement: Measurement, frame: int, ask: FitRequest) -> FitResult:
    """Raises FitRefused."""
    used = fit_frame_of(measurement, frame, ask)
    if used.verdict != "good":
        what, why = "a recorded fit cannot be made again", used.reason or ""
        remedy = "fit the recording again, and look for what has changed"
        raise FitRefused(what, where=f"frame {frame}", why=why, remedy=remedy)
    return used


def _mean_of(
    measurement: Measurement,
    reports: Sequence[FrameFit],
    short: Sequence[FrameFit],
    middle: int,
    used: FitResult,
    used_short: FitResult | None,
    declared: DeclaredUncertainty | None,
) -> BudgetParts:
    good = tuple(report.frame for report in reports)
    given = _situation(measurement, good, middle, used, declared)
    effects = effects_of(given)
    told = scatter_of(reports, given, [measurement.conditions(frame).temperature_c for frame in good])
    if short:
        by_frame = {report.frame: report for report in reports}
        difference, std = differences(given.names, [by_frame[fit.frame] for fit in short], short)
        if used_short is not None:
            std = np.hypot(std, explained(effects, effects_of(_by_fit(given, used_short, measurement, middle))))
        told = replace(told, difference=difference, difference_std=std)
    return BudgetParts(effects, given, told, good)


def budgets_of(
    measurement: Measurement,
    ask: FitRequest,
    shot: int | None,
    *,
    series: bool = False,
    declared: DeclaredUncertainty | None = None,
    coverage: float = 0.95,
) -> ResultBudgets:
    """Of one shot; None: of the mean of all, or of the only one unless `series` asks for a mean.

    Raises InputError as `shot_budgets` and `series_budgets` do.
    """
    usable = [k for k in range(measurement.frames) if measurement.excuse(k) is None]
    if shot is None and (series or len(usable) > 1):
        return series_budgets(measurement, ask, declared=declared, coverage=coverage)
    frame = shot if shot is not None else (usable or [0])[0]
    return shot_budgets(measurement, frame, ask, declared=declared, coverage=coverage)


def monte_carlo_of(budget: Budget, trials: int | None, *, seed: int = 0) -> MonteCarloResult:
    """Draw the inputs of a budget through its linear model, by their distributions; trials None: as many as needed."""
    lines = budget.contributions
    estimates = [line.input.value for line in lines]

    def model(*drawn: Array) -> Array:
        parts = (line.sensitivity * (x - at) for line, x, at in zip(lines, drawn, estimates, strict=True))
        return np.asarray(budget.value + sum(parts))

    between = {(one, other): r for one, other, r in budget.correlations}
    inputs = [line.input for line in lines]
    return monte_carlo(
        model, inputs, between, coverage=budget.coverage, trials=trials, seed=seed, quantity=budget.quantity
    )


def _situation(
    measurement: Measurement, frames: Sequence[int], frame: int, fit: FitResult, declared: DeclaredUncertainty | None
) -> Situation:
    recording = measurement.recording if isinstance(measurement, VoltageMeasurement) else None
    record = measurement.signal(frame).record
    if declared is not None:
        check_coefficients(declared, tuple(fit.parameters))
    said, day = DeclaredUncertainty(), datetime.now(UTC).date()
    if recording is not None and recording.provenance is not None:
        said = declared_in(recording)
        day = date.fromisoformat(recording.provenance.start_time[:10])
    calibrated = record.quantity == "dmdt"  # by whatever, of arrays: axes stand for its channels
    temperatures = [t for k in frames if (t := measurement.conditions(k).temperature_c) is not None]
    return Situation(
        fit=fit,
        response=response_of(fit, record) if calibrated else None,
        calibration=measurement.calibration or (ReceiveCalibration(np.eye(3)) if calibrated else None),
        specimen=None if recording is None or recording.provenance is None else declared_specimen(recording),
        declared=said.under(declared),
        measured=day,
        temperature_c=fmean(temperatures) if temperatures else None,
        temperature_change_k=max(temperatures) - min(temperatures) if temperatures else None,
    )


def _by_fit(given: Situation, fit: FitResult, measurement: Measurement, frame: int) -> Situation:
    """The same of another fit of the frame."""
    if given.response is None:
        return replace(given, fit=fit)
    return replace(given, fit=fit, response=response_of(fit, measurement.signal(frame).record))


def budgets_by(
    effects: Sequence[Effect], given: Situation, told: Statistics, frames: tuple[int, ...], coverage: float
) -> ResultBudgets:
    """The budgets of what the fits say, by the effects of every influence, which are those of `effects_of(given)`.

    Raises InputError for correlations that contradict each other.
    """
    known = [each for each in effects if each.known is not None]
    between = {each.between: each.r for each in given.declared.correlation}
    matrix = correlation_matrix([each.known for each in known if each.known is not None], between)
    budgets = tuple(_budget(k, told, effects, between, coverage) for k in range(len(told.names)))
    sizes = np.array([each.effects * (each.known.u if each.known else 0.0) for each in known]).reshape(
        len(known), len(told.names)
    )
    covariance = told.covariance + sizes.T @ matrix @ sizes + np.diag(told.model_u**2)
    rotation = cone = None
    if RODRIGUES[0] in told.names:
        places = [told.names.index(name) for name in RODRIGUES]
        back = np.linalg.inv(turned_to_rodrigues(told.values[places]))
        rotation = back @ covariance[np.ix_(places, places)] @ back.T
        cone = cone_angle(rotation, coverage, min(budgets[k].dof for k in places))
    return ResultBudgets(budgets, covariance, rotation, cone, frames, given.temperature_c, given.temperature_change_k)


def _budget(
    k: int, told: Statistics, effects: Sequence[Effect], between: dict[tuple[str, str], float], coverage: float
) -> Budget:
    quantity, value = told.names[k], float(told.values[k])
    lines: list[tuple[InputQuantity, float]] = []
    missing: list[NotDeclared] = []
    if (u := math.sqrt(told.covariance[k, k])) > 0.0:
        lines.append((InputQuantity(name=told.name, value=value, u=u, kind="A", dof=told.dof, source=told.source), 1.0))
    add_model(k, told, lines, missing)
    for each in effects:
        effect = float(each.effects[k])
        if each.known is not None and effect != 0.0:
            lines.append((each.known, effect))
    total = math.sqrt(sum((c * x.u) ** 2 for x, c in lines))
    missing += _undeclared(k, effects, _NEGLIGIBLE * total)
    paired = {name for pair in between for name in pair}
    kept = [(x, c) for x, c in lines if abs(c) * x.u > _NEGLIGIBLE * total or x.name in paired]
    inputs, names = [x for x, _ in kept], {x.name for x, _ in kept}
    own = {pair: r for pair, r in between.items() if set(pair) <= names}
    slopes = np.array([c for _, c in kept])
    return combine(quantity, value, inputs, slopes, own, coverage=coverage, not_declared=missing)


def _undeclared(k: int, effects: Sequence[Effect], least: float) -> list[NotDeclared]:
    """What nobody has declared, those of one kind together, as independent; what adds less than `least` is none."""
    squares: dict[str, float] = {}
    for each in effects:
        if each.known is None:
            name = f"{each.kind or each.name}, per {each.unit_text}"
            squares[name] = squares.get(name, 0.0) + (float(each.effects[k]) * each.unit) ** 2
    return [NotDeclared(name, math.sqrt(square)) for name, square in squares.items() if not math.sqrt(square) <= least]
