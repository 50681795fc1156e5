"""The calibration of a sensor by stored recordings, as a function of what can be sent to another process."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from drivers.errors import InputError, RecordingError
from drivers.specimen import Specimen
from platform_daemon.core.schemas.fits import FileDigest
from platform_daemon.core.schemas.text import same_name
from platform_daemon.features.measurand.schema import MeasurandCalibration

from .series import Series

if TYPE_CHECKING:
    from platform_daemon.features.measurand.reference_file import Reference
    from platform_daemon.features.measurand.shots import Shots

_NAMES = 20  # of others in a message


def _say_nothing(path: Path, note: str) -> None:
    pass


def calibration_by(
    specimen: Specimen,
    given: Sequence[Path] | Series,
    reference: tuple[Reference, FileDigest] | None,
    say: Callable[[Path, str], None] = _say_nothing,
    before: MeasurandCalibration | None = None,
) -> MeasurandCalibration:
    """The calibration of a resonator by recordings, or by those of a schedule that are of it; it is not kept.

    reference: its readings, and what they were read from; None: the thermometer of the platform.  say: is told what a
    reader must know of a file.  before: the calibration before, see `calibrated`.

    Raises InputError for a resonator that is no sensor, recordings of another one, or of several samples, a schedule
    without a readable one of it, and what `calibrated` refuses; RecordingError for a file that was named; one of a
    schedule that cannot be read is left out, and told in the notes.
    """
    # Here, because the process that sends it needs none of it: numba and scipy take 0.7 s of a processor to load.
    from platform_daemon.features.measurand.shots import joined
    from platform_daemon.features.measurand.thermometer import NOTE, thermometer_readings
    from platform_daemon.features.measurand.work import calibrated, declared_measurand

    measurand = declared_measurand(specimen, specimen.name)
    taken = _taken(specimen, given, say)
    shots = joined(taken.shots)
    if not shots.times_s.size:
        why = f"{len(shots.refused)} shots were refused"
        remedy = "look at the fits of the recordings: `platform-daemon fit FILE` says why"
        raise InputError("no shot has a good fit", where=specimen.name, why=why, remedy=remedy)
    _refuse_same_times(shots, specimen.name)
    readings = thermometer_readings(shots, measurand, specimen.name) if reference is None else reference[0]
    made = calibrated(specimen.name, measurand, shots, readings, 0, before=before)
    notes, files = list(taken.notes), taken.files
    found: dict[str, object] = {}
    if reference is None:  # f changes with the temperature: that is the curve
        notes.append(NOTE)
        found["by_temperature_hz_per_k"] = None
    else:
        files = (reference[1], *files)
    return made.model_copy(update={**found, "files": files, "notes": (*made.notes, *notes)})


def _refuse_same_times(shots: Shots, name: str) -> None:
    """Raises InputError: a copy of a recording that is not the same byte for byte would count its shots twice."""
    again = shots.times_s[1:][shots.times_s[1:] == shots.times_s[:-1]]
    if len(again):
        at = datetime.fromtimestamp(float(again[0]), UTC).isoformat(timespec="milliseconds")
        what, remedy = "two shots were made at the same time", "leave out the recording that is a copy of another"
        raise InputError(what, where=name, why=f"at {at}, and {len(again)} times in all", remedy=remedy)


@dataclass(frozen=True, eq=False)
class _Taken:
    """What recordings hold of a resonator: shots (n) and digests (n) of each, and notes of what was left out."""

    shots: tuple[Shots, ...]
    files: tuple[FileDigest, ...]
    notes: tuple[str, ...]


def _taken(specimen: Specimen, given: Sequence[Path] | Series, say: Callable[[Path, str], None]) -> _Taken:
    """Of a schedule, what is of another resonator or cannot be read is left out; of named files it is an error."""
    from platform_daemon.core.recordings.evidence import file_digests

    scheduled = isinstance(given, Series)
    shots: dict[FileDigest, Shots] = {}
    by_content: dict[str | None, str] = {}
    samples: Counter[str] = Counter()
    others: Counter[str] = Counter()
    unread: list[str] = []
    twice: list[str] = []
    for file in given.files if isinstance(given, Series) else given:
        (digest,) = file_digests((file,))
        if digest.sha256 is not None and digest.sha256 in by_content:
            twice.append(f"{file.name} is {by_content[digest.sha256]}")
            continue
        try:
            found = _shots_in(file, specimen, say)
        except RecordingError as error:
            if not scheduled:
                raise
            unread.append(f"{file.name}: {error.what}" + (f" ({error.why})" if error.why else ""))
            continue
        if isinstance(found, str):
            if not scheduled:
                raise _other(file, found, specimen.name)
            others[found] += 1
            continue
        by_content[digest.sha256] = file.name
        shots[digest], sample = found
        samples[sample] += 1
    if isinstance(given, Series) and not shots:
        raise _nothing_of_it(given, specimen.name, others, unread)
    if len(samples) > 1:
        what, why = "the recordings are of several samples", f"they are of {_listed(samples)}"
        remedy = "each has a curve of its own: give the recordings of one, or a file for each with a name of its own"
        raise InputError(what, where=specimen.name, why=why, remedy=remedy)
    notes = [f"named twice, and counted once: {', '.join(twice)}"] if twice else []
    if isinstance(given, Series):
        notes = [*_notes(given, len(shots), others, unread), *notes]
    return _Taken(tuple(shots.values()), tuple(shots), tuple(notes))


def _shots_in(file: Path, specimen: Specimen, say: Callable[[Path, str], None]) -> tuple[Shots, str] | str:
    """The shots of a recording and the sample that it names; of another resonator its name.  Raises RecordingError."""
    from platform_daemon.features.fit.fit_request import FitSettings
    from platform_daemon.features.fit.known_moment import declared_specimen
    from platform_daemon.features.fit.measurement import VoltageMeasurement, open_shots_for_fit
    from platform_daemon.features.measurand.shots import shots_of

    measurement, ask = open_shots_for_fit(file, FitSettings(None, "d30"))
    recording = measurement.recording if isinstance(measurement, VoltageMeasurement) else None
    p = None if recording is None else recording.provenance
    declared = None if recording is None or p is None else declared_specimen(recording)
    if declared is not None and same_name(declared.name) != same_name(specimen.name):
        return declared.name
    say(measurement.path, measurement.other_layout)
    return shots_of(measurement, ask), same_name(p.sample_name) if p is not None else ""


def _nothing_of_it(series: Series, name: str, others: Counter[str], unread: Sequence[str]) -> InputError:
    if not others:
        what, remedy = "no recording of the schedule can be read", "restore them from a copy, or record others"
        return InputError(what, where=series.schedule, why=_first(unread), remedy=remedy)
    why = f"its recordings are of {_listed(others)}" + (f"; not readable: {_first(unread)}" if unread else "")
    remedy = "name the resonator that they are of"
    return InputError(f"the schedule has no recording of {name!r}", where=series.schedule, why=why, remedy=remedy)


def _notes(series: Series, taken: int, others: Counter[str], unread: Sequence[str]) -> list[str]:
    notes = [f"recordings of the schedule {series.schedule!r}: {taken}"]
    if others:
        notes.append(f"of other resonators, and left out: {_listed(others)}")
    if unread:
        notes.append(f"not readable, and left out: {_first(unread)}")
    if series.missing:
        notes.append(f"not there any more: {series.missing}")
    return notes


def _first(told: Sequence[str]) -> str:
    return "; ".join(told[:_NAMES]) + (f"; and {len(told) - _NAMES} more" if len(told) > _NAMES else "")


def _other(file: Path, name: str, wanted: str) -> InputError:
    why = f"it is of {name!r}, not of {wanted!r}"
    remedy = "leave it out, or calibrate the resonator that it is of"
    return InputError("the recording is of another resonator", where=str(file), why=why, remedy=remedy)


def _listed(names: Counter[str]) -> str:
    return ", ".join(f"{name or 'no name'} ({count})" for name, count in names.most_common(_NAMES))
