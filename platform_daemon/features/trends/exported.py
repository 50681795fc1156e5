"""All on-line fits of a specimen as one table."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import closing
from pathlib import Path
from typing import TypeGuard

from platform_daemon.core.recordings.header import FitTable
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recorded_fits import read_fit
from platform_daemon.core.recordings.recording import Recording
from platform_daemon.core.recordings.recording_index import open_index
from platform_daemon.core.schemas.fits import BLANK
from platform_daemon.core.schemas.text import same_name

from .baseline import in_utc
from .indexed import check_known

Row = dict[str, str | float]


def exported_fits(folder: Path, specimen: str) -> list[Row]:
    """A row per shot and window, oldest recording first, with what was refused: where it is from, verdicts, figures of
    the fit, then estimates by name with unit, each with its standard deviation (`NAME_std`), and the noise of each
    channel.  Times are in UTC; what is not known is not in the row; one that was held has no standard deviation.

    Raises UnknownSpecimen, InputError for a time that is none, RecordingError, StorageError.
    """
    specimen = same_name(specimen)
    with closing(open_index(folder)) as index:
        check_known(index, specimen)
        names = [name for name, _, _, whose, _ in index.files() if whose == specimen]
        rows: list[Row] = []
        for name in names:
            recording = open_recording(folder / name)
            noises = {shot.frame: shot.values for shot in index.shots(recording.path.stem)}
            for fit in recording.fits:
                rows += _rows(recording, read_fit(recording, fit), noises)
    return rows


def _rows(recording: Recording, table: FitTable, noises: Mapping[int, Mapping[str, float]]) -> Iterator[Row]:
    for k, info in enumerate(recording.frame_info):
        said: dict[str, str | float | None] = {
            "recording": recording.path.stem,
            "frame": k,
            "at": None if info.time_stamp is None else in_utc(info.time_stamp, str(recording.path)).isoformat(),
            "shot_verdict": info.verdict,
            "temperature_c": info.temperature_c,
            "field_t": None if info.excitation is None else info.excitation.field_t,
            "fit": table.name,
            "variant": table.variant,
            "verdict": "blank" if table.reason[k] == BLANK else table.verdict[k],  # earlier versions: refused
            "reason": table.reason[k],
            "window_s": float(table.window_s[k]),
            "chi2_per_dof": float(table.chi2_per_dof[k]),
            "nrmse": float(table.nrmse[k]),
            "r2": float(table.r2[k]),
        }
        for j, name in enumerate(table.parameters):
            said |= {name: float(table.values[k, j]), f"{name}_std": float(table.std[k, j])}
        said |= {name: value for name, value in noises.get(k, {}).items() if name.startswith("noise_")}
        yield {name: value for name, value in said.items() if _known(value)}


def _known(value: str | float | None) -> TypeGuard[str | float]:
    return bool(value) if isinstance(value, str) else value is not None and math.isfinite(value)
