"""Points of one step of the procedures of a specimen, where that is not the last one, which the index holds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from drivers.errors import InputError
from platform_daemon.core.recordings.index import resolve
from platform_daemon.core.recordings.indexed import IndexedRecording
from platform_daemon.core.recordings.procedure_steps import ALL_STEPS, RecordedStep, chosen_step, steps_of_procedure
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recording_index import RecordingIndex

from .points import points_in


def of_step(
    folder: Path, index: RecordingIndex, recordings: Sequence[IndexedRecording], step: str
) -> tuple[list[IndexedRecording], list[str]]:
    """Recordings with the points of that step, and the ids of procedures without it, which are left out.

    step: number or name, of several with that name the last; recordings that no procedure has made stay as they are.
    Raises InputError for all steps, which a point must not mix, and where procedures were found, but none has that
    step; RecordingError.
    """
    if step == ALL_STEPS:
        remedy = "name one step, by its number or name"
        raise InputError("a trend takes one step of each procedure", where="step", remedy=remedy)
    kept: list[IndexedRecording] = []
    missing: list[str] = []
    names: dict[str, None] = {}
    for each in recordings:
        if not each.step:
            kept.append(each)
            continue
        recording = open_recording(resolve(folder, each.identifier))
        steps = steps_of_procedure(recording)
        names |= dict.fromkeys(name for one in steps for name in (one.name, str(one.number)) if name)
        if any(step in (one.name, str(one.number)) for one in steps):
            taken = chosen_step(recording, step)
            assert taken is not None
            kept.append(_with_points(index, each, taken[0]))
        else:
            missing.append(each.identifier)
    if missing and not any(each.step for each in kept):
        remedy = f"name one of {', '.join(names)}"
        raise InputError(f"no procedure of this specimen has a step {step!r}", where="step", remedy=remedy)
    return kept, missing


def _with_points(index: RecordingIndex, recording: IndexedRecording, step: RecordedStep) -> IndexedRecording:
    shots = [shot for shot in index.shots(recording.identifier) if shot.frame in step.frames]
    return replace(recording, points=points_in(shots), step=str(step))
