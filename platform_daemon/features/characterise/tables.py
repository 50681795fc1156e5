"""Fit both windows, make the tables, choose the shot of the figures."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median

from drivers.errors import InputError, RecordingError
from platform_daemon import __version__
from platform_daemon.core.recordings.description import describe
from platform_daemon.core.recordings.procedure_steps import ALL_STEPS, refuse_mixture
from platform_daemon.core.schemas.derived import EnvelopesReport, FrameQuantities
from platform_daemon.core.schemas.fits import BLANK, FitReport, FrameFit
from platform_daemon.core.schemas.parameters import names_in_order
from platform_daemon.features.budget.schema import BudgetReport
from platform_daemon.features.budget.work import parts_of_fits
from platform_daemon.features.budget.written import budget_report
from platform_daemon.features.fit.batch.executors import WorkerPool
from platform_daemon.features.fit.batch.run import Advanced, Finished, fit_files
from platform_daemon.features.fit.derived import frame_envelopes
from platform_daemon.features.fit.fit_request import FitRequest, FitSettings
from platform_daemon.features.fit.measurement import VoltageMeasurement, open_for_fit, open_voltages, taken_frames
from platform_daemon.features.fit.plot_data import RingDownPlotData, ring_down_plot_data
from platform_daemon.features.models.resolve import ModelChoice, label_of

from .comparison import Pairs, compare
from .dataset import PHASE, ShotValues, dataset_of, orientation_reference, shot_values
from .notes import notes_of
from .schema import (
    CharacterisationReport,
    FitDataset,
    OrientationReference,
    ParameterUncertainty,
    QualityFactors,
    ShotStatistics,
    WindowComparison,
)
from .statistics import statistics_of

ORIENTATION_ERROR = "orientation_error_rad"
"""Name of the orientation error among the compared quantities."""
HELD = "lambda_per_s"
"""The loss that N50 holds if a model has several (tab:model_fit_params)."""
COVERAGE = 0.95
"""Of the intervals of the means."""
_FEWEST = 2  # good fits, for a scatter
_ENVELOPE_POINTS = 400
_SLOW = " of a rotor of five degrees of freedom, some 10 s of processor time a shot"
_OF_ONE_ANGLE = (
    "quality factors, envelopes and the figure of a shot are those of one angle, and are left out for a rotor with a "
    "manufacturing error"
)
Tell = Callable[[str, float], None]
"""What is being done, and the share of it all that is done, 0 to 1; may raise to end it."""


@dataclass(frozen=True)
class CharacterisationTask:
    """What is to be characterised, checked.

    Attributes:
        path: of the recording; settings: model, calibration, further terms, and the excited shots in it.
        held: losses held in N50, by name; None: of a model with several losses lambda, at the median of D30.
        alpha: level of significance.
        remarks: what is known of the shots beforehand, in words.
    """

    path: Path
    settings: FitSettings
    held: Mapping[str, float] | None
    alpha: float
    remarks: tuple[str, ...] = ()

    @property
    def frames(self) -> int:
        """Shots."""
        return len(self.settings.frames or ())

    def opened(self) -> tuple[VoltageMeasurement, FitRequest]:
        """The recording as the settings want it, and what is asked of a D30 fit."""
        measurement, ask = open_for_fit(self.path, self.settings)
        assert isinstance(measurement, VoltageMeasurement)
        return measurement, ask


def characterisation_task(
    path: Path, settings: FitSettings, held: Mapping[str, float] | None, alpha: float
) -> CharacterisationTask:
    """Everything that can be checked before the first fit.

    Raises InputError for a file without excited shots, a model that cannot be used, a loss that cannot be held;
    RecordingError for a file that is no recording.
    """
    open_voltages(path)  # an angle has neither a moment nor an orientation
    settings = replace(settings, window="n50", fixed=dict(held or {}))
    measurement, ask = open_for_fit(path, settings)
    check_held_in_n50(ask.model, held or {})
    if settings.step == ALL_STEPS:
        remedy = "name one step by its number or name, or leave it out for the last one"
        raise InputError("means over all steps of a procedure would mix them", where="step", remedy=remedy)
    taken, said = taken_frames(measurement, settings.frames, settings.step)
    assert isinstance(measurement, VoltageMeasurement)
    refuse_mixture(measurement.recording, taken)
    frames = [k for k in taken if measurement.excuse(k) != BLANK]
    if not frames:
        remedy = "choose frames of excited shots, or another recording"
        raise InputError("there is no excited shot", where=str(path), remedy=remedy)
    derived = not ask.of_rotor  # quality factors are those of one angle's motion
    settings = replace(settings, window="d30", fixed=None, derived=derived, frames=tuple(frames), step=None)
    return CharacterisationTask(path, settings, held, alpha, said)


def check_held_in_n50(model: ModelChoice, held: Mapping[str, float]) -> None:
    """Raises InputError for what is no loss of the model, and where none is left to be fitted."""
    losses = FitRequest(model).one_angle.ring_down_model.losses
    unknown = [name for name in held if name not in losses]
    if unknown:
        remedy = f"hold one of {', '.join(losses)}, or none"
        raise InputError(f"{unknown[0]} is no loss of {label_of(model)}", where="held_in_n50", remedy=remedy)
    if len(held) == len(losses):
        raise InputError("no loss is left to be fitted", where="held_in_n50", remedy="leave one of them free")


def characterise(task: CharacterisationTask, workers: WorkerPool, tell: Tell) -> CharacterisationReport:
    """Fit every shot in both windows and make the tables.

    One part of the file's frames is in memory at a time, per worker.  Raises what `tell` raises; PlatformError if no
    frame can be read.
    """
    began = time.perf_counter()
    slow = _SLOW if task.opened()[1].of_rotor else ""
    d30 = _fitted(task.path, task.settings, workers, lambda share: tell(f"D30 fits{slow}", 0.5 * share))
    held = _held(task, d30)
    settings = replace(task.settings, window="n50", fixed=held or None)
    n50 = _fitted(task.path, settings, workers, lambda share: tell(f"N50 fits{slow}", 0.5 + 0.48 * share))
    tell("tables", 0.98)
    report = _report(task, n50, d30, held)
    return report.model_copy(update={"seconds": time.perf_counter() - began})


def _fitted(path: Path, settings: FitSettings, workers: WorkerPool, tell: Callable[[float], None]) -> FitReport:
    """The fits of one window.  Raises PlatformError if no frame can be read."""
    tell(0.0)
    for event in fit_files([path], settings, workers):
        if isinstance(event, Advanced):
            tell(event.share)
        elif isinstance(event, Finished):
            tell(1.0)
            return event.report.model_copy(update={"value_sources": None})  # the characterisation has them
        else:
            raise event.error
    raise AssertionError("a file neither finished nor failed")


def _held(task: CharacterisationTask, d30: FitReport) -> dict[str, float]:
    """What N50 holds: its window cannot tell several losses apart (tab:model_fit_params).

    The paper takes lambda from another specimen's D30 fits, the thread's; one specimen alone has its own.
    """
    if task.held is not None:
        return dict(task.held)
    losses = task.opened()[1].one_angle.ring_down_model.losses
    known = [frame.values[HELD] for frame in d30.good_frames if HELD in frame.parameters]
    if len(losses) < 2 or HELD not in losses or not known:
        return {}
    return {HELD: max(0.0, median(known))}


def _report(
    task: CharacterisationTask, n50: FitReport, d30: FitReport, held: Mapping[str, float]
) -> CharacterisationReport:
    measurement, ask = task.opened()
    info = describe(measurement.recording)
    first = (task.settings.frames or (0,))[0]
    receive_s = _receive_s(measurement, first)
    reference = orientation_reference(d30)
    short, long = shot_values((n50, d30), reference)
    shown = _shown(d30)
    comparisons = compare(_pairs(short, long, held, reference), task.alpha)
    budgets, without = budgets_of_means(measurement, ask, n50, d30, held)
    whole = dataset_of("d30", d30, long, {})
    summary = CharacterisationReport(
        software_version=__version__,
        file=str(task.path),
        sample=info.sample or None,
        measured=info.shots[first].time_stamp if info.shots else None,
        variant=ask.label,
        calibration=d30.calibration,
        excitation=info.shots[first].excitation if info.shots else None,
        receive_s=receive_s,
        n50=dataset_of("n50", n50, short, held),
        d30=whole,
        orientation_reference=reference,
        alpha=task.alpha,
        comparisons=comparisons,
        uncertainties=_uncertainties(whole, comparisons),
        mean_budgets=tuple(each for each in budgets if each.quantity in whole.parameters) or None,
        quality_factors=_quality_factors(n50, d30),
        shown_frame=None if shown is None else shown.frame,
        envelopes=_envelopes(ask, shown, n50, receive_s),
        value_sources=measurement.value_sources(task.settings.frames or ()) or None,
        notes=(),
        n50_fits=n50,
        d30_fits=d30,
        seconds=0.0,
    )
    notes = (*task.remarks, *notes_of(summary, task.held is not None, info), *without)
    notes += (_OF_ONE_ANGLE,) if ask.of_rotor else ()
    return summary.model_copy(update={"notes": notes})


def budgets_of_means(
    measurement: VoltageMeasurement, ask: FitRequest, n50: FitReport, d30: FitReport, held: Mapping[str, float]
) -> tuple[tuple[BudgetReport, ...], tuple[str, ...]]:
    """Of the means of the D30 fits; none, and a note with the reason, where there is no budget.

    Where fewer than two fits are good, other notes say so.
    """
    if len(d30.good_frames) < _FEWEST:
        return (), ()
    if ask.of_rotor:
        return (), ("the means have no uncertainty budget: influences are propagated through the model of one angle",)
    try:
        made = parts_of_fits(measurement, ask, d30.good_frames, n50.good_frames, held)
        return tuple(map(budget_report, made.budgets(COVERAGE).budgets)), ()
    except (InputError, RecordingError) as error:
        return (), (f"the means have no uncertainty budget: {error}",)


def _receive_s(measurement: VoltageMeasurement, k: int) -> float:
    recording = measurement.recording
    step = recording.frame_info[k].step
    samples = recording.sequence.rx_samples if step is None else step.rx_samples
    return samples / recording.sequence.rate_hz


def _pairs(
    short: ShotValues, long: ShotValues, held: Mapping[str, float], reference: OrientationReference | None
) -> list[Pairs]:
    """What is compared: every fitted parameter, and the orientation error, of the shots that are good in both."""
    both = [k for k in short.parameters if k in long.parameters]
    names = {name for k in both for name in short.parameters[k].keys() & long.parameters[k].keys()}
    found = []
    for name in names_in_order({name for name in names if not name.startswith("rodrigues_")}):
        if name in held:
            found.append(Pairs(name, reason=f"held at {held[name]:.4g} in N50"))
            continue
        one, other = ([values.parameters[k][name] for k in both] for values in (short, long))
        found.append(Pairs(name, one, other, circular=name == PHASE))
    return [*found, _orientation_pairs(short, long, reference)]


def _orientation_pairs(short: ShotValues, long: ShotValues, reference: OrientationReference | None) -> Pairs:
    """Without the shot of reference: its own D30 error is zero by construction."""
    if reference is None:
        return Pairs(ORIENTATION_ERROR, reason="there is no orientation of reference")
    both = [k for k in short.errors_rad if k in long.errors_rad and k != reference.frame]
    return Pairs(ORIENTATION_ERROR, [short.errors_rad[k] for k in both], [long.errors_rad[k] for k in both])


def _uncertainties(d30: FitDataset, comparisons: Iterable[WindowComparison]) -> tuple[ParameterUncertainty, ...]:
    differences = {row.quantity: row.difference for row in comparisons}
    found = []
    for name, over in d30.parameters.items():
        parts = over.std, differences.get(name), over.systematic_std
        known = [part for part in parts if part is not None]
        scatter, difference, systematic = parts
        found.append(
            ParameterUncertainty(
                parameter=name,
                value=over.mean,
                scatter=scatter,
                window_difference=difference,
                systematic_std=systematic,
                uncertainty=math.hypot(*known) if known else None,
            )
        )
    return tuple(found)


def _quality_factors(n50: FitReport, d30: FitReport) -> QualityFactors:
    short, long = ([f.derived for f in r.good_frames if isinstance(f.derived, FrameQuantities)] for r in (n50, d30))

    def over(frames: Sequence[FrameQuantities], name: str) -> ShotStatistics | None:
        return statistics_of(getattr(q, name) for q in frames)

    return QualityFactors(
        n50=over(short, "equivalent_quality_factor"),
        d30=over(long, "equivalent_quality_factor"),
        infinity=over(long, "equivalent_quality_factor_to_infinity"),
        viscous=over(long, "quality_factor"),
    )


def _shown(d30: FitReport) -> FrameFit | None:
    """The good fit whose R² is the median, the lower one of two."""
    good = sorted(d30.good_frames, key=lambda frame: frame.r2 or 0.0)
    return good[(len(good) - 1) // 2] if good else None


def _envelopes(
    ask: FitRequest, shown: FrameFit | None, n50: FitReport, receive_s: float
) -> tuple[EnvelopesReport, ...]:
    """By the shot's D30 fit and by its N50 fit, as far as they are there and know the moment."""
    frames = [] if shown is None or ask.of_rotor else [shown, *(f for f in n50.good_frames if f.frame == shown.frame)]
    known = [frame for frame in frames if "m_r_am2" in frame.parameters]
    return tuple(frame_envelopes(ask.ring_down_model, f, _ENVELOPE_POINTS, receive_s) for f in known)


def shown_shot(task: CharacterisationTask, report: CharacterisationReport) -> RingDownPlotData | None:
    """The shot of the figures with its D30 fit, made again; None if there is none."""
    measurement, ask = task.opened()
    if report.shown_frame is None or ask.of_rotor:
        return None
    return ring_down_plot_data(measurement, report.shown_frame, ask.model, "d30")
