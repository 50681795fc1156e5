"""What the points of a trend are worth: U by a budget of the newest recording that was made under the same conditions.

A budget needs a fit with its data, so that one for each of thousands of points would take hours.  Of points under the
same model and calibration everything but the number of shots is alike: what they share is that of the newest recording
(of the drift since the calibration that is the most), and the scatter of the mean is that of its shots, over as many as
the point has.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from drivers.errors import InputError, RecordingError
from platform_daemon.core.recordings.index import resolve
from platform_daemon.core.recordings.indexed import IndexedRecording
from platform_daemon.features.budget.work import BudgetParts, parts_of_series, parts_of_shot
from platform_daemon.features.fit.fit_request import FitSettings
from platform_daemon.features.fit.measurement import open_for_fit, taken_frames
from platform_daemon.uncertainty.budget import Budget

from .schema import TrendPoint, TrendReport

COVERAGE = 0.95
"""Of value ± U."""
Kind = tuple[str | None, str | None]
"""Fit and calibration: what the budget depends on, apart from the number of shots."""


@dataclass(frozen=True, eq=False)
class _Worth:
    """What points of one kind are worth.

    parts: of their budgets; with_temperature: they hold for a temperature that was measured; by_shots: budgets that
    were asked for, by parameter.
    """

    parts: BudgetParts
    recording: str
    with_temperature: bool
    by_shots: dict[int, Mapping[str, Budget]] = field(default_factory=dict)

    def budget(self, quantity: str, shots: int) -> Budget | None:
        """Of the mean of so many shots; None: the fits have no such parameter."""
        if shots not in self.by_shots:
            made = self.parts.budgets(COVERAGE, shots).budgets
            self.by_shots[shots] = {each.quantity: each for each in made}
        return self.by_shots[shots].get(quantity)


def with_uncertainty(
    report: TrendReport, folder: Path, recordings: Sequence[IndexedRecording], step: str | None
) -> TrendReport:
    """The report with U of every listed value.

    folder, recordings: that it was made of; step: of procedures.  Where there is no budget, a note says why.
    """
    known = {each.identifier: each for each in recordings}
    kinds = [_kind(known[point.recording]) for point in report.points]
    worth: dict[Kind, _Worth] = {}
    notes: list[str] = []
    for kind, recording in _newest(report.points, kinds).items():
        try:
            worth[kind] = _worth_of(resolve(folder, recording), known[recording], step)
        except (InputError, RecordingError) as error:
            notes.append(f"U is not known of fits as those of {recording}: {error}")
    charts = []
    for chart in report.charts:
        found = [
            _expanded(worth.get(kind), chart.quantity, value, point)
            for value, kind, point in zip(chart.value, kinds, report.points, strict=True)
        ]
        charts.append(chart.model_copy(update={"U": tuple(found)} if any(u is not None for u in found) else {}))
    notes += [note for each in worth.values() for note in _notes(each)]
    return report.model_copy(update={"charts": tuple(charts), "notes": (*report.notes, *notes)})


def _kind(recording: IndexedRecording) -> Kind:
    return recording.fit, recording.calibration


def _newest(points: Sequence[TrendPoint], kinds: Sequence[Kind]) -> dict[Kind, str]:
    """The newest recording of each kind, of those with points of several shots if there are any."""
    found: dict[Kind, TrendPoint] = {}
    for point, kind in zip(points, kinds, strict=True):
        if kind not in found or point.shots > 1 or found[kind].shots == 1:
            found[kind] = point
    return {kind: point.recording for kind, point in found.items()}


def _worth_of(path: Path, recording: IndexedRecording, step: str | None) -> _Worth:
    """Raises InputError for a model that only the folder of adopted models knows, and as budgets do; RecordingError."""
    window, _, model = (recording.fit or "").partition(" ")
    if window not in ("d30", "n50"):
        raise InputError(f"fits over the window {window!r} have no budget", where=str(path), remedy="fit over D30")
    measurement, ask = open_for_fit(path, FitSettings(None, "d30" if window == "d30" else "n50"))
    if model not in ("", ask.label):
        remedy = "`platform-daemon budget --variant` makes one"
        raise InputError(f"its fits are of the model {model}", where=str(path), remedy=remedy)
    taken, _ = taken_frames(measurement, None, step if recording.step else None)
    usable = [k for k in taken if measurement.excuse(k) is None]
    if len(usable) > 1:
        parts = parts_of_series(measurement, ask, frames=usable)
    else:
        parts = parts_of_shot(measurement, (usable or [0])[0], ask)
    return _Worth(parts, recording.identifier, parts.given.temperature_c is not None)


def _expanded(worth: _Worth | None, quantity: str, value: float | None, point: TrendPoint) -> float | None:
    """U of a value; None: of what no fit has, and where the temperature counts but was not measured."""
    if worth is None or value is None or not math.isfinite(value):
        return None
    if worth.with_temperature and point.temperature_c is None:
        return None
    budget = worth.budget(quantity, point.shots)
    return None if budget is None else budget.expanded


def _notes(worth: _Worth) -> list[str]:
    missing = dict.fromkeys(
        each.name
        for budget in (worth.budget(name, 1) for name in ("f_nat_hz", "m_r_am2"))
        for each in (() if budget is None else budget.not_declared)
        if not each.looked_for
    )
    said = f"U ({COVERAGE:.0%}) is by the budget of {worth.recording}"
    return [f"{said}; not declared, and not contained: {'; '.join(missing) or 'nothing'}"]
