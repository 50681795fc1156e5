"""Files as the diagnosis takes them: shots of one specimen with their noise, and what was wrong with the files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np

from drivers.errors import InputError, PlatformError, RecordingError
from platform_daemon.diagnosis import (
    DataDefect,
    Diagnosis,
    DiagnosisError,
    DiagnosisShot,
    ProgressCallback,
    diagnose_shots,
)
from platform_daemon.estimation import (
    LostTrajectoryError,
    Refusal,
    RefusedError,
    RingDownModel,
    SeriesNoise,
    estimate_noise,
    screen_free_swing,
)

from .frames import chosen_frames
from .measurement import PENDULUM, AngleMeasurement, Calibration, Measurement, VoltageMeasurement, open_measurement
from .model_registry.resolve import ModelChoice, model_of, notes_of

Observable = Literal["dmdt", "angle"]
FramesByFile = Mapping[Path, Sequence[int] | None]
"""Frames of recordings by path, from 0; None, or a path that is missing: all."""
OBSERVABLES: tuple[Observable, ...] = ("dmdt", "angle")

_NO_FREE_SWING = (Refusal.NOT_FINITE, Refusal.TOO_SHORT, Refusal.NO_SIGNAL, Refusal.NO_DECAY)
ABSORBED = (
    "no calibration: every coil has two free sensitivities, of the odd harmonics and of the even ones, which take up "
    "the gains of the channels, their mixing, the orientation and the moment; effects of these kinds cannot be seen"
)
"""What volts cannot tell."""


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
    """

    shots: tuple[DiagnosisShot, ...]
    model: RingDownModel
    flaws: tuple[DataDefect, ...]
    notes: tuple[str, ...]
    files: tuple[Path, ...]


@dataclass
class _Loaded:
    """What has been read so far; remedies: for what was left out, where there is a better one than another record."""

    shots: list[DiagnosisShot]
    flaws: list[DataDefect]
    notes: list[str]
    refusals: list[str] = field(default_factory=list)
    remedies: list[str] = field(default_factory=list)

    def leave_out(self, name: str, why: str, remedy: str = "") -> None:
        """A frame that is no good."""
        self.refusals.append(f"{name} was left out: {why}")
        self.notes.append(self.refusals[-1])
        self.remedies += [remedy] if remedy else []


def load_diagnosis_input(
    files: Sequence[Path],
    model: ModelChoice | None = None,
    observable: Observable | None = None,
    base: ModelChoice | None = None,
    calibration: Calibration | None = None,
    frames: FramesByFile | None = None,
) -> DiagnosisInput:
    """Read recordings or angle series of one specimen.

    Args:
        files: shots or recordings of one specimen.
        model: a declared or adopted one; None: what the files say.
        observable: None: what the first file holds.
        base: a declared or adopted model to start from in the place of the model.
        calibration: in the place of the files' own, and where it came from.
        frames: of recordings that are not to be taken whole, by their path.

    Raises:
        InputError: files that cannot be read, do not belong together, or hold no sensitivity; an unknown model.
        NothingToDiagnoseError: no frame is left.
    """
    measurements, chosen = _opened(files, base or model, observable, calibration)
    loaded = _Loaded([], [], [*_doubts(measurements), *notes_of(chosen)])
    if isinstance(measurements[0], AngleMeasurement) and not (base or model):
        loaded.notes.append(f"no variant was named: the declared model is {PENDULUM}, a pendulum with viscous damping")
    angles = [m for m in measurements if isinstance(m, AngleMeasurement)]
    shared = SeriesNoise()
    for one in angles:
        if one.series.finite:
            shared.learn(one.signal(0).record)
    for one in angles:
        _add_angle(one, shared, loaded)
    for recorded in measurements:
        if isinstance(recorded, VoltageMeasurement):
            _add_frames(recorded, loaded, chosen_frames(recorded, (frames or {}).get(recorded.path)))
    return _specimen(loaded, model_of(chosen), tuple(m.path for m in measurements))


def check_diagnosis_input(
    files: Sequence[Path],
    model: ModelChoice | None = None,
    observable: Observable | None = None,
    calibration: Calibration | None = None,
    frames: FramesByFile | None = None,
) -> None:
    """What load_diagnosis_input raises before it has looked at any frame."""
    for measurement in _opened(files, model, observable, calibration)[0]:
        chosen_frames(measurement, (frames or {}).get(measurement.path))


def _opened(
    files: Sequence[Path], wanted: ModelChoice | None, observable: Observable | None, calibration: Calibration | None
) -> tuple[list[Measurement], ModelChoice]:
    """Files that can be diagnosed together, each once, as the model of all of them wants them.  Raises InputError."""
    opened = [open_measurement(path, calibration) for path in dict.fromkeys(map(Path, files))]
    angles = isinstance(opened[0], AngleMeasurement) if observable is None else observable == "angle"
    volts = observable is None and opened[0].calibration is None
    for measurement in opened:
        _check(measurement, angle=angles, volts=volts)
    _check_channels(opened)
    chosen = _one_variant(opened, wanted)
    return [measurement.under(chosen)[0] for measurement in opened], chosen


def _check(measurement: Measurement, *, angle: bool, volts: bool) -> None:
    """Raises RecordingError for an angle where there should be none, for a file without one, for volts beside dm/dt.

    volts: the first file has no calibration, and none was asked for.
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
            why="dm/dt was asked for, or the first file is calibrated, and volts alone do not tell dm/dt",
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
    """Diagnose, and add what was seen while reading.  Raises NothingToDiagnoseError."""
    try:
        found = diagnose_shots(specimen.shots, specimen.model, tell)
    except (DiagnosisError, LostTrajectoryError, np.linalg.LinAlgError) as error:
        raise NothingToDiagnoseError(
            "nothing could be diagnosed", where=_named(specimen.files), why=str(error),
            remedy="look at the fits of these frames, and name the right variant",
        ) from None  # fmt: skip
    return replace(found, integrity=(*specimen.flaws, *found.integrity), notes=(*specimen.notes, *found.notes))


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


def _add_frames(measurement: VoltageMeasurement, loaded: _Loaded, frames: Sequence[int]) -> None:
    """Good frames of a recording with its noise; blank ones only tell the noise."""
    noise, sensitivity = measurement.noise(), None
    if measurement.calibration is not None:
        sensitivity = np.asarray(measurement.calibration.sensitivity, dtype=np.float64)
        sensitivity = sensitivity if sensitivity.shape[0] == sensitivity.shape[1] else None
    elif ABSORBED not in loaded.notes:
        loaded.notes.append(ABSORBED)
    unit = "counts" if measurement.recording.counts else ""
    for k in frames:
        info = measurement.recording.frame_info[k]
        name = f"{measurement.path.name} frame {k}"
        if info.blank:
            continue
        if info.verdict != "good":
            loaded.leave_out(name, info.reason or info.verdict)
            continue
        try:
            signal = measurement.signal(k)
        except PlatformError as error:
            loaded.leave_out(name, error.what)
            continue
        clipped = signal.clipping()
        if clipped is not None:
            loaded.flaws.append(DataDefect("saturation", f"{name}: {clipped}", -1))
            loaded.leave_out(name, f"saturated: {clipped}", "record excited shots without clipping")
            continue
        of_shot = noise.for_shot(signal.record)
        if of_shot.model is None:
            loaded.leave_out(name, "its noise cannot be measured")
            continue
        loaded.notes += [f"{name}: {note}" for note in (*signal.notes, of_shot.note) if note]
        group = measurement.path.name
        loaded.shots.append(DiagnosisShot(name, signal.record, of_shot.model, sensitivity, group, unit))


def _add_angle(measurement: AngleMeasurement, noise: SeriesNoise, loaded: _Loaded) -> None:
    """An angle series is one shot, with a common noise where several are alike."""
    name, signal = measurement.path.name, measurement.signal(0)
    loaded.flaws += [DataDefect("clock_gap", f"{name}: {text}", -1) for text in signal.notes]
    if not measurement.series.finite:
        loaded.flaws.append(DataDefect("not_finite", f"{name}: samples are not finite numbers", -1))
    try:
        screen_free_swing(signal.record)
    except RefusedError as refused:
        # What else is wrong is told by the fits, or beside them.
        if refused.code in _NO_FREE_SWING:
            code, advice = refused.code.name.lower(), refused.advice or refused.code.value.rpartition("; ")[2]
            loaded.leave_out(name, f"{code}: {refused.seen}", advice)
            return
    # A short record says nothing about others, and something about itself.
    model = noise.for_shot(signal.record).model or estimate_noise(signal.record)
    loaded.shots.append(DiagnosisShot(name, signal.record, model, None, name))


def _specimen(loaded: _Loaded, model: RingDownModel, files: tuple[Path, ...]) -> DiagnosisInput:
    """Raises NothingToDiagnoseError if nothing is left."""
    if not loaded.shots:
        why = "; ".join(loaded.refusals[-4:]) or "all frames are blank"
        remedy = "; ".join(dict.fromkeys(loaded.remedies[-4:])) or "record excited shots without clipping"
        raise NothingToDiagnoseError("no shot can be used", where=_named(files), why=why, remedy=remedy)
    return DiagnosisInput(tuple(loaded.shots), model, tuple(loaded.flaws), _short(loaded.notes), files)


def _short(notes: Iterable[str]) -> tuple[str, ...]:
    """Each once."""
    return tuple(dict.fromkeys(notes))
