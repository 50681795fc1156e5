"""The calibration of a sensor by stored recordings, as a function of what can be sent to another process."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from drivers.errors import InputError
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
) -> MeasurandCalibration:
    """The calibration of a resonator by recordings, or by those of a schedule that are of it; it is not kept.

    reference: its readings, and what they were read from; None: the thermometer of the platform.  say: is told what a
    reader must know of a file.  Raises InputError for a resonator that is no sensor, recordings of another one, or of
    several samples, a schedule without one of it, and what `calibrated` refuses; RecordingError.
    """
    # Here, because the process that sends it needs none of it: numba and scipy take 0.7 s of a processor to load.
    from platform_daemon.core.recordings.evidence import file_digests
    from platform_daemon.features.measurand.shots import joined
    from platform_daemon.features.measurand.thermometer import NOTE, thermometer_readings
    from platform_daemon.features.measurand.work import calibrated, declared_measurand

    measurand = declared_measurand(specimen, specimen.name)
    taken, notes = _taken(specimen, given, say)
    shots = joined(list(taken.values()))
    if not shots.times_s.size:
        why = f"{len(shots.refused)} shots were refused"
        remedy = "look at the fits of the recordings: `platform-daemon fit FILE` says why"
        raise InputError("no shot has a good fit", where=specimen.name, why=why, remedy=remedy)
    readings = thermometer_readings(shots, measurand, specimen.name) if reference is None else reference[0]
    made = calibrated(specimen.name, measurand, shots, readings, 0)
    found: dict[str, object] = {"files": file_digests(taken)}
    if reference is None:  # f changes with the temperature: that is the curve
        notes.append(NOTE)
        found["by_temperature_hz_per_k"] = None
    else:
        found["files"] = (reference[1], *file_digests(taken))
    return made.model_copy(update={**found, "notes": (*made.notes, *notes)})


def _taken(
    specimen: Specimen, given: Sequence[Path] | Series, say: Callable[[Path, str], None]
) -> tuple[Mapping[Path, Shots], list[str]]:
    """The shots by recording, and notes of what was left out."""
    from platform_daemon.features.fit.fit_request import FitSettings
    from platform_daemon.features.fit.known_moment import declared_specimen
    from platform_daemon.features.fit.measurement import VoltageMeasurement, open_shots_for_fit
    from platform_daemon.features.measurand.shots import shots_of

    scheduled = isinstance(given, Series)
    taken: dict[Path, Shots] = {}
    samples: Counter[str] = Counter()
    others: Counter[str] = Counter()
    for file in dict.fromkeys(given.files if isinstance(given, Series) else given):
        measurement, ask = open_shots_for_fit(file, FitSettings(None, "d30"))
        recording = measurement.recording if isinstance(measurement, VoltageMeasurement) else None
        p = None if recording is None else recording.provenance
        declared = None if recording is None or p is None else declared_specimen(recording)
        if declared is not None and declared.name != specimen.name:
            if not scheduled:
                raise _other(file, declared.name, specimen.name)
            others[declared.name] += 1
            continue
        say(measurement.path, measurement.other_layout)
        taken[file] = shots_of(measurement, ask)
        samples[same_name(p.sample_name) if p is not None else ""] += 1
    if isinstance(given, Series) and not taken:
        what, why = f"the schedule has no recording of {specimen.name!r}", f"its recordings are of {_listed(others)}"
        raise InputError(what, where=given.schedule, why=why, remedy="name the resonator that they are of")
    if len(samples) > 1:
        what, why = "the recordings are of several samples", f"they are of {_listed(samples)}"
        remedy = "each has a curve of its own: give the recordings of one, or a file for each with a name of its own"
        raise InputError(what, where=specimen.name, why=why, remedy=remedy)
    return taken, _notes(given, taken, others) if isinstance(given, Series) else []


def _notes(series: Series, taken: Mapping[Path, Shots], others: Counter[str]) -> list[str]:
    notes = [f"recordings of the schedule {series.schedule!r}: {len(taken)}"]
    if others:
        notes.append(f"of other resonators, and left out: {_listed(others)}")
    if series.missing:
        notes.append(f"not there any more: {series.missing}")
    return notes


def _other(file: Path, name: str, wanted: str) -> InputError:
    why = f"it is of {name!r}, not of {wanted!r}"
    remedy = "leave it out, or calibrate the resonator that it is of"
    return InputError("the recording is of another resonator", where=str(file), why=why, remedy=remedy)


def _listed(names: Counter[str]) -> str:
    return ", ".join(f"{name or 'no name'} ({count})" for name, count in names.most_common(_NAMES))
