"""Files as the diagnosis takes them: shots of one specimen with their noise, and what was wrong with the files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from drivers.calibration import ReceiveCalibration
from drivers.errors import InputError, PlatformError, RecordingError
from platform_daemon.diagnosis import (
    DataDefect,
    Diagnosis,
    DiagnosisError,
    DiagnosisShot,
    ProgressCallback,
    diagnose_shots,
)
from platform_daemon.estimation import LostTrajectoryError, RingDownModel, SeriesNoise, find_clipping
from platform_daemon.store import AngleSeries, Recording, is_time_series, open_recording, read_angles

from .calibrated import ring_down
from .fit_request import NAME_THE_VARIANT, checked_variant
from .frames import chosen_frames
from .measurement import angle_record
from .model_registry.resolve import ModelChoice, model_of, notes_of, with_receiver_correction
from .noise import recording_noise

Observable = Literal["dmdt", "angle"]
FramesByFile = Mapping[Path, Sequence[int] | None]
"""Frames of recordings by path, from 0; None, or a path that is missing: all."""
OBSERVABLES: tuple[Observable, ...] = ("dmdt", "angle")
_PENDULUM = "thread"  # of an angle, about which no file says what swings: restoring torque and viscous damping


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
    """What has been read so far."""

    shots: list[DiagnosisShot]
    flaws: list[DataDefect]
    notes: list[str]
    refusals: int = 0

    def leave_out(self, name: str, why: str) -> None:
        """A frame that is no good."""
        self.notes.append(f"{name} was left out: {why}")
        self.refusals += 1


def load_diagnosis_input(
    files: Sequence[Path],
    variant: ModelChoice | None = None,
    observable: Observable | None = None,
    base: ModelChoice | None = None,
    calibration: tuple[ReceiveCalibration, str] | None = None,
    frames: FramesByFile | None = None,
) -> DiagnosisInput:
    """Read recordings or angle series of one specimen.

    Args:
        files: shots or recordings of one specimen.
        variant: a declared or adopted model; None: what the files say.
        observable: None: what the first file holds.
        base: a declared or adopted model to start from in the place of the variant.
        calibration: in the place of the files' own, and where it came from.
        frames: of recordings that are not to be taken whole, by their path.

    Raises:
        InputError: files that cannot be read, do not belong together, or hold no sensitivity; an unknown model.
        NothingToDiagnoseError: no frame is left.
    """
    files = tuple(dict.fromkeys(Path(f) for f in files))
    if _observed(files, observable) == "angle":
        return _angles(files, base or variant)
    return _ring_downs(files, base or variant, calibration, frames or {})


def check_diagnosis_input(
    files: Sequence[Path],
    variant: ModelChoice | None = None,
    observable: Observable | None = None,
    calibration: tuple[ReceiveCalibration, str] | None = None,
    frames: FramesByFile | None = None,
) -> None:
    """What load_diagnosis_input raises before it has read any samples."""
    if _observed(files, observable) == "angle":
        _checked(variant or _PENDULUM)
        for path in files:
            _must_be_time_series(path)
        return
    recordings = [_opened(path, calibration) for path in files]
    chosen = _one_variant(recordings, variant)
    for recording in recordings:
        with_receiver_correction(recording, chosen)
        chosen_frames(recording, (frames or {}).get(recording.path))


def _must_be_time_series(path: Path) -> None:
    if not is_time_series(path):
        remedy = "leave the observable out, or name a file with /time and /signal"
        raise RecordingError("holds no angle: /time and /signal are missing", where=str(path), remedy=remedy)


def _observed(files: Sequence[Path], observable: Observable | None) -> Observable:
    return observable or ("angle" if is_time_series(files[0]) else "dmdt")


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


def _checked(variant: ModelChoice) -> ModelChoice:
    """Raises InputError for a name that is not declared."""
    return checked_variant(variant) if isinstance(variant, str) else variant


def _ring_downs(
    files: tuple[Path, ...],
    variant: ModelChoice | None,
    calibration: tuple[ReceiveCalibration, str] | None,
    frames: FramesByFile,
) -> DiagnosisInput:
    recordings = [_opened(path, calibration) for path in files]
    chosen = _one_variant(recordings, variant)
    loaded = _Loaded([], [], [*_specimen_notes(recordings), *notes_of(chosen)])
    for recording in recordings:
        _add_frames(
            with_receiver_correction(recording, chosen), loaded, chosen_frames(recording, frames.get(recording.path))
        )
    return _specimen(loaded, model_of(chosen), files)


def _opened(path: Path, calibration: tuple[ReceiveCalibration, str] | None) -> Recording:
    """A recording with a calibration.  Raises RecordingError."""
    if is_time_series(path):
        remedy = "diagnose it as an angle (--observable, or `observable` of a request), alone or with others like it"
        raise RecordingError("holds an angle (/time, /signal), not coil voltages", where=str(path), remedy=remedy)
    recording = open_recording(path)
    if calibration is not None:
        recording = recording.with_calibration(*calibration)
    if recording.calibration is None:
        raise RecordingError(
            "has no sensitivity",
            where=f"{path}: /calibration/sensitivity",
            why="the diagnosis needs dm/dt, and volts alone do not tell it",
            remedy="give a calibration (--calibration), or record with one",
        )
    return recording


def _one_variant(recordings: Sequence[Recording], wanted: ModelChoice | None) -> ModelChoice:
    """The model of all files.  Raises InputError if they differ or say nothing."""
    said = {r.variant: r.path for r in reversed(recordings) if r.variant is not None}
    if len(said) > 1:
        what = "; ".join(f"{path.name} holds a {name}" for name, path in said.items())
        raise InputError(
            "the files hold different resonators", where="FILE...", why=what, remedy="diagnose each specimen by itself"
        )
    chosen = wanted or next(iter(said), None)
    if chosen is None:
        raise RecordingError(
            "the file does not say which resonator it holds",
            where=f"{recordings[0].path}: /resonator/variant",
            remedy=NAME_THE_VARIANT,
        )
    return _checked(chosen)


def _specimen_notes(recordings: Sequence[Recording]) -> list[str]:
    """Doubts whether it is one specimen."""
    names = dict.fromkeys(r.provenance.sample_name for r in recordings if r.provenance and r.provenance.sample_name)
    if len(names) > 1:
        return [f"the files name different samples ({', '.join(names)}); they were taken for one specimen"]
    return []


def _add_frames(recording: Recording, loaded: _Loaded, frames: Sequence[int]) -> None:
    """Good frames of a recording with its noise; blank ones only tell the noise."""
    assert recording.calibration is not None
    noise = recording_noise(recording)
    sensitivity = np.asarray(recording.calibration.sensitivity, dtype=np.float64)
    square = sensitivity if sensitivity.shape[0] == sensitivity.shape[1] else None
    for k in frames:
        info = recording.frame_info[k]
        name = f"{recording.path.name} frame {k}"
        if info.blank:
            continue
        if info.verdict != "good":
            loaded.leave_out(name, info.reason or info.verdict)
            continue
        try:
            volts = recording.rx_volts(k)
            record, assumed = ring_down(volts, recording.sequence.rate_hz, recording.calibration)
        except PlatformError as error:
            loaded.leave_out(name, error.what)
            continue
        clipped = find_clipping(volts)
        if clipped is not None:
            loaded.flaws.append(DataDefect("saturation", f"{name}: {clipped}", -1))
            loaded.leave_out(name, f"saturated: {clipped}")
            continue
        of_shot = noise.for_shot(record)
        if of_shot.model is None:
            loaded.leave_out(name, "its noise cannot be measured")
            continue
        loaded.notes += [f"{name}: {note}" for note in (*assumed, of_shot.note) if note]
        loaded.shots.append(DiagnosisShot(name, record, of_shot.model, square, recording.path.name))


def _angles(files: tuple[Path, ...], variant: ModelChoice | None) -> DiagnosisInput:
    """Angle series, one shot each, with a common noise where they are alike."""
    series = [read_angles(path) for path in files]
    loaded = _Loaded([], [], [])
    if variant is None:
        loaded.notes.append(f"no variant was named: the declared model is {_PENDULUM}, a pendulum with viscous damping")
    model = model_of(_checked(variant or _PENDULUM))
    noise = SeriesNoise()
    for one in series:
        if one.finite:
            noise.learn(angle_record(one))
    for one in series:
        _add_angles(one, noise, loaded)
    return _specimen(loaded, model, files)


def _add_angles(series: AngleSeries, noise: SeriesNoise, loaded: _Loaded) -> None:
    name = series.path.name
    loaded.flaws += [DataDefect("clock_gap", f"{name}: {text}", -1) for text in series.clock]
    if not series.finite:
        loaded.flaws.append(DataDefect("not_finite", f"{name}: samples are not finite numbers", -1))
        loaded.leave_out(name, "samples are not finite numbers")
        return
    record = angle_record(series)
    model = noise.for_shot(record).model
    if model is None:
        loaded.leave_out(name, "its noise cannot be measured: too few samples")
        return
    loaded.shots.append(DiagnosisShot(name, record, model, None, name))


def _specimen(loaded: _Loaded, model: RingDownModel, files: tuple[Path, ...]) -> DiagnosisInput:
    """Raises NothingToDiagnoseError if nothing is left."""
    if not loaded.shots:
        why = "; ".join(loaded.notes[-4:]) or "all frames are blank"
        remedy = "record excited shots without clipping"
        raise NothingToDiagnoseError("no shot can be used", where=_named(files), why=why, remedy=remedy)
    return DiagnosisInput(tuple(loaded.shots), model, tuple(loaded.flaws), _short(loaded.notes), files)


def _short(notes: Iterable[str]) -> tuple[str, ...]:
    """Each once."""
    return tuple(dict.fromkeys(notes))
