"""Calibrations of measurands on disk: one file per version, written whole, never overwritten."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

from drivers.errors import InputError
from drivers.text_files import read_text_file
from drivers.validation import validated
from platform_daemon.core.recordings.index import Broken
from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.schemas.text import same_name
from platform_daemon.core.state.versioned import Version, VersionedFolder

from .schema import MeasurandCalibration

_ELSEWHERE = "; calibrations of another folder are named by --measurands"


class UnknownMeasurand(InputError):
    """No calibration of a measurand has that name or version."""

    title = "Unknown measurand"
    http_status = 404


class Measurands:
    """The calibrations in a folder; it need not exist before the first is added."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._files = folder, VersionedFolder(folder, r"\.json")

    def add(self, made: MeasurandCalibration) -> MeasurandCalibration:
        """Keep a calibration as the next version of its specimen's.

        Its key is the one that its specimen has already, else its own, with a number if that is another specimen's.
        Raises StorageError, InputError for a damaged file under that key.
        """
        key = self._free_key(made.key, made.specimen)
        kept: list[MeasurandCalibration] = []

        def content(number: int, _: str) -> bytes:
            kept[:] = [made.model_copy(update={"key": key, "version": number})]
            return to_json(kept[0], indent=1).encode()

        self._files.add(key, ".json", content)
        return kept[0]

    def _free_key(self, wanted: str, specimen: str) -> str:
        for number in itertools.count(1):
            key = wanted if number == 1 else f"{wanted}-{number}"
            versions = self._files.versions(key)
            if not versions or same_name(_read(versions[-1]).specimen) == same_name(specimen):
                return key
        raise AssertionError("counting ends")

    def get(self, text: str) -> MeasurandCalibration:
        """KEY@VERSION, or KEY: its newest version.  Raises UnknownMeasurand, InputError for a damaged file."""
        name, at, number = text.partition("@")
        versions = self._files.versions(name)
        wanted = [v for v in versions if not at or str(v.number) == number]
        if not wanted:
            known = ", ".join(v.path.stem for v in self._files.versions()) or "none yet"
            why, remedy = f"there are: {known}", f"`platform-daemon measurand calibrate` makes one{_ELSEWHERE}"
            raise UnknownMeasurand(f"no calibration {text!r}", where=str(self._folder), why=why, remedy=remedy)
        return _read(wanted[-1])

    def of_specimen(self, specimen: str) -> MeasurandCalibration:
        """The newest calibration of a specimen, by its name.  Raises UnknownMeasurand."""
        found = self.newest_of(specimen)
        if found is None:
            remedy = f"`platform-daemon measurand calibrate` makes one, or name another specimen's{_ELSEWHERE}"
            what = f"{specimen!r} is not calibrated as a sensor"
            raise UnknownMeasurand(what, where=str(self._folder), remedy=remedy)
        return found

    def newest_of(self, specimen: str) -> MeasurandCalibration | None:
        """The same; None: it has no calibration."""
        found = [each for each in self.all()[0] if same_name(each.specimen) == same_name(specimen)]
        return max(found, key=lambda each: (each.ended, each.version), default=None)

    def all(self) -> tuple[list[MeasurandCalibration], list[Broken]]:
        """Every version of every calibration, and the files that hold none."""
        found, broken = [], []
        for version in self._files.versions():
            try:
                found.append(_read(version))
            except InputError as error:
                broken.append(Broken(version.path.stem, version.path, error))
        return found, broken


def _read(version: Version) -> MeasurandCalibration:
    from .consistency import contradiction  # numpy, which a daemon without sensors does not need

    try:
        found = validated(MeasurandCalibration, json.loads(read_text_file(version.path)), version.path.name)
        if (found.key, found.version) != (version.name, version.number):
            raise ValueError(f"it holds {found.label}")
        if why := contradiction(found):
            raise ValueError(why)
    except (OSError, ValueError, RecursionError, InputError) as error:
        why = error.what if isinstance(error, InputError) else str(error)
        remedy = "restore the file from a copy, or remove it and calibrate again"
        what = "is no calibration of a measurand"
        raise InputError(what, where=str(version.path), why=why, remedy=remedy) from None
    return found
