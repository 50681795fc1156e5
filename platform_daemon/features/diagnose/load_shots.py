"""Files as the diagnosis takes them: shots of one specimen with their noise, and what was wrong with the files."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np

from drivers.errors import InputError, RecordingError
from platform_daemon.core.schemas.value_sources import ValueSource
from platform_daemon.diagnosis.diagnose import Diagnosis, DiagnosisError, diagnose_shots
from platform_daemon.diagnosis.report_schema import RecordedSources
from platform_daemon.diagnosis.selection.data_integrity import DataDefect
from platform_daemon.diagnosis.selection.restoring_law import is_of_spring
from platform_daemon.diagnosis.selection.stepwise import ProgressCallback
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.estimation.noise.series import SeriesNoise
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError
from platform_daemon.features.fit.measurement import (
    PENDULUM,
    SPRING,
    AngleMeasurement,
    Calibration,
    Measurement,
    VoltageMeasurement,
    open_measurement,
    taken_frames,
)
from platform_daemon.features.models.resolve import ModelChoice, model_of, notes_of

from .shot_reading import LoadedShots, add_angle, add_frames, searched_frames

Observable = Literal["dmdt", "angle"]
FramesByFile = Mapping[Path, Sequence[int] | None]
"""Frames of recordings by path, from 0; None, or a path that is missing: all, of a procedure those of a step."""
StepsByFile = Mapping[Path, str | None]
"""Steps of recordings of procedures by path: number, name, or all; None, or a path that is missing: the last one."""
OBSERVABLES: tuple[Observable, ...] = ("dmdt", "angle")


class NothingToDiagnoseError(InputError):
    """The files can be read, but none of their shots can be diagnosed."""

    title = "Nothing to diagnose"


@dataclass(frozen=True)
class DiagnosisInput:
    """What is to be diagnosed.

    Attributes:
        shots: of all files, with a measured noise.
        model: the declared model that all of them shall obey.
        flaws: seen while the files were read; their `shot` is -1.
        notes: frames that were left out and why, and what had to be assumed.
        files: in the order in which they were named.
        further: shots that are not searched because they are too many, each read when it is called; None from one
            that cannot be used.
        sources: where the values of each recording come from, and its calibration, by its path.
    """

    shots: tuple[DiagnosisShot, ...]
    model: RingDownModel
    flaws: tuple[DataDefect, ...]
    notes: tuple[str, ...]
    files: tuple[Path, ...]
    further: tuple[Callable[[], DiagnosisShot | None], ...] = ()
    sources: Mapping[Path, tuple[ValueSource, ...]] = field(default_factory=dict)

    def recorded_sources(self, name: Callable[[Path], str]) -> list[RecordedSources]:
        """Where the values of the files come from, each with its name."""
        return [RecordedSources(file=name(path), value_sources=found) for path, found in self.sources.items() if found]


def load_diagnosis_input(
    files: Sequence[Path | Measurement],
    model: ModelChoice | None = None,
    observable: Observable | None = None,
    base: ModelChoice | None = None,
    calibration: Calibration | None = None,
    frames: FramesByFile | None = None,
    steps: StepsByFile | None = None,
) -> DiagnosisInput:
    """Read recordings or angle series of one specimen.

    Args:
        files: shots or recordings of one specimen, by their paths or opened.
        model: a declared or adopted one; None: what the files say, of angles a pendulum or a linear spring.
        observable: None: what the first file holds.
        base: a declared or adopted model to start from in the place of the model.
        calibration: in the place of the files' own, and where it came from.
        frames: of recordings that are not to be taken whole, by their path.
        steps: of recordings of procedures, by their path.

    Raises:
        InputError: files that cannot be read, do not belong together, or hold no sensitivity; an unknown model.
        NothingToDiagnoseError: no frame is left.
    """
    measurements, chosen = _opened(files, base or model, observable, calibration)
    loaded = LoadedShots([], [], [*_doubts(measurements), *notes_of(chosen)])
    loaded.notes += [f"{m.path}: {m.other_layout}" for m in measurements if m.other_layout]
    angles = [m for m in measurements if isinstance(m, AngleMeasurement)]
    shared = SeriesNoise()
    for swing in angles:
        if swing.series.finite:
            shared.learn(swing.signal(0).record)
    for swing in angles:
        add_angle(swing, shared, loaded)
    recorded = []
    for m in measurements:
        if isinstance(m, VoltageMeasurement):
            taken, said = taken_frames(m, (frames or {}).get(m.path), (steps or {}).get(m.path))
            recorded.append((m, taken))
            loaded.notes += said
    unnamed = bool(angles) and not (base or model)
    declared = _of_pendulum_or_spring(loaded) if unnamed else model_of(chosen)
    declared = declared.under_weight(measurements[0].weight_over_pull())
    for (one, numbers), searched in zip(recorded, searched_frames(recorded), strict=True):
        add_frames(one, numbers, searched, declared.name, loaded)
    if loaded.further:
        loaded.notes.append(
            f"of {len(loaded.shots) + len(loaded.further)} shots {len(loaded.shots)}, evenly spread, are searched and "
            "fitted together"
        )
    specimen = _specimen(loaded, declared, tuple(m.path for m in measurements))
    return replace(specimen, sources={one.path: one.value_sources(numbers) for one, numbers in recorded})


def _of_pendulum_or_spring(loaded: LoadedShots) -> RingDownModel:
    """The declared model of angles for which nobody named one, with a note."""
    pendulum, spring = model_of(PENDULUM), model_of(SPRING)
    if is_of_spring(loaded.shots, pendulum, spring):
        loaded.notes.append(
            f"no variant was named: the declared model is {SPRING}, a linear spring with viscous damping, which leaves "
            f"far less than a pendulum, {PENDULUM}"
        )
        return spring
    loaded.notes.append(f"no variant was named: the declared model is {PENDULUM}, a pendulum with viscous damping")
    return pendulum


def check_diagnosis_input(
    files: Sequence[Path | Measurement],
    model: ModelChoice | None = None,
    observable: Observable | None = None,
    calibration: Calibration | None = None,
    frames: FramesByFile | None = None,
    steps: StepsByFile | None = None,
) -> None:
    """What load_diagnosis_input raises before it has looked at any frame."""
    for measurement in _opened(files, model, observable, calibration)[0]:
        taken_frames(measurement, (frames or {}).get(measurement.path), (steps or {}).get(measurement.path))


def _opened(
    files: Sequence[Path | Measurement],
    wanted: ModelChoice | None,
    observable: Observable | None,
    calibration: Calibration | None,
) -> tuple[list[Measurement], ModelChoice]:
    """Files that can be diagnosed together, each once, as the model of all of them wants them.  Raises InputError."""
    opened = [
        each if isinstance(each, Measurement) else open_measurement(each, calibration) for each in dict.fromkeys(files)
    ]
    angles = isinstance(opened[0], AngleMeasurement) if observable is None else observable == "angle"
    volts = observable is None and opened[0].calibration is None
    for measurement in opened:
        _check(measurement, angle=angles, volts=volts)
    _check_channels(opened)
    chosen = _one_variant(opened, wanted)
    return [measurement.under(chosen)[0] for measurement in opened], chosen


def _check(measurement: Measurement, *, angle: bool, volts: bool) -> None:
    """Raises RecordingError for an angle where there should be none, for a file without one, for volts among dm/dt.

    volts: the first file has no calibration, and none was requested.
    """
    where = str(measurement.path)
    if angle and not isinstance(measurement, AngleMeasurement):
        remedy = "leave the observable out, or name a file with /time and /signal"
        raise RecordingError("holds no angle: /time and /signal are missing", where=where, remedy=remedy)
    if isinstance(measurement, AngleMeasurement):
        if not angle:
            remedy = (
                "diagnose it as an angle (--observable, or `observable` of a request), alone or with others like it"
            )
            raise RecordingError("holds an angle (/time, /signal), not coil voltages", where=where, remedy=remedy)
    elif measurement.calibration is None and not volts:
        raise RecordingError(
            "has no sensitivity",
            where=f"{where}: /calibration/sensitivity",
            why="dm/dt was requested, or the first file is calibrated, and volts alone do not tell dm/dt",
            remedy="give a calibration (--calibration), or diagnose volts by themselves, without --observable",
        )
    elif measurement.calibration is not None and volts:
        raise RecordingError(
            "is calibrated, and the first file is not", where=where, remedy="diagnose volts and dm/dt by themselves"
        )


def _check_channels(measurements: Sequence[Measurement]) -> None:
    """Raises RecordingError for files with different numbers of channels."""
    counts = {m.recording.channels: m.path for m in measurements if isinstance(m, VoltageMeasurement)}
    if len(counts) > 1:
        what = "; ".join(f"{path.name} has {count}" for count, path in counts.items())
        remedy = "diagnose files of the same coils together"
        raise RecordingError("the files have different numbers of channels", where="FILE...", why=what, remedy=remedy)


def diagnose_input(specimen: DiagnosisInput, tell: ProgressCallback) -> Diagnosis:
    """Diagnose the shots of files.  Raises NothingToDiagnoseError."""
    try:
        return diagnose_shots(
            specimen.shots,
            specimen.model,
            tell,
            specimen.further,
            defects=specimen.flaws,
            remarks=specimen.notes,
        )
    except (DiagnosisError, LostTrajectoryError, np.linalg.LinAlgError) as error:
        raise NothingToDiagnoseError(
            "nothing could be diagnosed", where=_named(specimen.files), why=str(error),
            remedy="look at the fits of these frames, and name the right variant",
        ) from None  # fmt: skip


def _named(files: Sequence[Path]) -> str:
    more = f" and {len(files) - 1} more" if len(files) > 1 else ""
    return f"{files[0]}{more}"


def _one_variant(measurements: Sequence[Measurement], wanted: ModelChoice | None) -> ModelChoice:
    """The model of all files.  Raises InputError if they differ or say nothing."""
    said = {m.variant: m.path for m in reversed(measurements) if m.variant is not None}
    if len(said) > 1:
        what = "; ".join(f"{path.name} holds a {name}" for name, path in said.items())
        raise InputError(
            "the files hold different resonators", where="FILE...", why=what, remedy="diagnose each specimen by itself"
        )
    return measurements[0].under(wanted or next(iter(said), None))[1]


def _doubts(measurements: Sequence[Measurement]) -> list[str]:
    """Doubts whether it is one specimen."""
    recorded = [m.recording.provenance for m in measurements if isinstance(m, VoltageMeasurement)]
    names = dict.fromkeys(p.sample_name for p in recorded if p and p.sample_name)
    if len(names) > 1:
        return [f"the files name different samples ({', '.join(names)}); they were taken for one specimen"]
    return []


def _specimen(loaded: LoadedShots, model: RingDownModel, files: tuple[Path, ...]) -> DiagnosisInput:
    """Raises NothingToDiagnoseError if nothing is left."""
    if not loaded.shots:
        why = "; ".join(loaded.refusals[-4:]) or "all frames are blank"
        remedy = "; ".join(dict.fromkeys(loaded.remedies[-4:])) or "record excited shots without clipping"
        raise NothingToDiagnoseError("no shot can be used", where=_named(files), why=why, remedy=remedy)
    notes = _short(loaded.notes)
    return DiagnosisInput(tuple(loaded.shots), model, tuple(loaded.flaws), notes, files, tuple(loaded.further))


def _short(notes: Iterable[str]) -> tuple[str, ...]:
    """Each once."""
    return tuple(dict.fromkeys(notes))
