"""The work of what is asked for on stored recordings: fits, diagnoses, characterisations."""

from __future__ import annotations

from typing import Any

from drivers.errors import InputError
from platform_daemon import analysis, reports  # not their parts, which load numba, half of scipy and matplotlib
from platform_daemon.engine import (
    CharacterisationFiles,
    CharacterisationWork,
    DiagnosisTask,
    DiagnosisWork,
    FitTask,
    FitWork,
    Work,
)
from platform_daemon.schemas import CharacterisationRequest, DiagnosisRequest, RecordingFitRequest
from platform_daemon.store import resolve as path_of

from .context import Context


def fit_work(request: RecordingFitRequest, context: Context) -> FitWork:
    """Raises InputError for a file, model, window or frame that cannot be."""
    path = path_of(context.recordings, request.recording)
    settings = analysis.FitSettings(
        model=analysis.resolve(request.variant, context.models),
        window=request.window,
        fixed=request.fixed or None,
        hold_if_inseparable=request.hints or None,
        terms=tuple(request.terms),
    )
    measurement, _ = analysis.open_for_fit(path, settings)
    frames = analysis.chosen_frames(measurement, request.frames)
    return FitWork(request, FitTask(path, settings, frames), context.fits, context.analyses.computer)


def diagnosis_work(request: DiagnosisRequest, context: Context) -> DiagnosisWork:
    """Raises InputError for a file or model that cannot be."""
    files = {path_of(context.recordings, part.recording): part.frames for part in request.parts()}
    model: analysis.ModelChoice | None = analysis.resolve(request.base or request.variant, context.models)
    task = DiagnosisTask(request, files, model, reports.diagnosis_html)
    analysis.check_diagnosis_input(list(files), model, request.observable, frames=files)
    return DiagnosisWork(request, task, context.diagnoses, context.analyses.computer)


def characterisation_work(request: CharacterisationRequest, context: Context) -> CharacterisationWork:
    """Raises InputError for a file, model or frame that cannot be."""
    frames = None if request.frames is None else tuple(request.frames)
    settings = analysis.FitSettings(
        analysis.resolve(request.variant, context.models), terms=tuple(request.terms), frames=frames
    )
    path = path_of(context.recordings, request.recording)
    task = analysis.characterisation_task(path, settings, request.held_in_n50 or None, request.alpha)
    files = CharacterisationFiles(reports.characterisation_html, context.characterisations)
    return CharacterisationWork(request, task, files, context.analyses.computer)


def work_of(request: Any, context: Context) -> Work[Any, Any]:
    """Of any of the three.  Raises InputError."""
    match request:
        case RecordingFitRequest():
            return fit_work(request, context)
        case DiagnosisRequest():
            return diagnosis_work(request, context)
        case CharacterisationRequest():
            return characterisation_work(request, context)
    raise InputError(f"no work is known for {type(request).__name__}", where="request", remedy="ask for it again")
