"""A noise sweep from its options to its report, and the two specimens that are compared by it."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from drivers.errors import InputError
from platform_daemon.features.characterise.schema import CharacterisationReport
from platform_daemon.features.characterise.tables import CharacterisationTask
from platform_daemon.features.fit.batch.executors import WorkerPool
from platform_daemon.features.fit.batch.part import InputFile

from .noise_curves import noise_report
from .noise_fits import added_sd, own_noise
from .noise_parts import NoiseSweep, make_parts, parts_of, prepare_parts
from .noise_schema import NoiseSweepReport

LEVELS = 30
"""As many as in fig:noise_plot."""
LOWEST_AM2_PER_S, HIGHEST_AM2_PER_S = 0.03, 1.5
"""Levels of fig:noise_plot."""
PARTS = "noise-parts"
"""Folder of the parts in that of the report."""


@dataclass(frozen=True)
class NoiseOptions:
    """What a sweep is made of.

    Attributes:
        low, high: levels, A m^2/s; low None: the noise of the noisier recording, at least the paper's lowest.
        draws: of noise for each shot and level; seed: of noise and bootstrap.
        shard: number from 1, of so many, to make its parts only; None: all.
        merge: put together what is there, and make nothing.
    """

    low: float | None
    high: float
    draws: int = 1
    seed: int = 1
    shard: tuple[int, int] | None = None
    merge: bool = False


def parse_levels(text: str) -> tuple[float, float]:
    """FROM:TO in A m^2/s.  Raises InputError."""
    match text.split(":"):
        case [low, high]:
            try:
                found = float(low), float(high)
            except ValueError:
                found = (0.0, 0.0)
            if 0.0 < found[0] < found[1] < 1e3:
                return found
    what = f"{text!r} is no range of levels"
    raise InputError(what, where="--noise", remedy="give FROM:TO in A m2/s, rising, as 0.03:1.5")


def parse_shard(text: str) -> tuple[int, int]:
    """i/N.  Raises InputError."""
    found = re.fullmatch(r"(\d{1,6})/(\d{1,6})", text)
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        remedy = "give its number from 1, a slash, and how many there are, as 3/8"
        raise InputError(f"{text!r} is no shard", where="--shard", remedy=remedy)
    return int(found[1]), int(found[2])


def sweep_of(
    tasks: Sequence[CharacterisationTask], reports: Sequence[CharacterisationReport], options: NoiseOptions
) -> NoiseSweep:
    """The sweep over the shots that have an N50 fit.

    Raises InputError for recordings without a calibration or with less than two such shots, and for a level below the
    own noise of one of them.
    """
    specimens = []
    for task, report in zip(tasks, reports, strict=True):
        frames = tuple(fit.frame for fit in report.n50_fits.good_frames)
        if report.orientation_reference is None or len(frames) < 2:
            why = "two shots with a calibration and a good fit in both windows are needed"
            remedy = "leave --noise out, or measure again with a calibration"
            raise InputError("there is nothing to add noise to", where=str(task.path), why=why, remedy=remedy)
        settings = replace(task.settings, window="n50", fixed=report.n50.held or None, frames=frames, derived=False)
        specimens.append((task.path, settings))
    own = [own_noise(InputFile(path), settings)[0] for path, settings in specimens]
    low = max(LOWEST_AM2_PER_S, *(float(np.mean(sd)) for sd in own)) if options.low is None else options.low
    for (path, _), sd in zip(specimens, own, strict=True):
        try:
            added_sd(sd, low)
        except InputError as error:
            raise InputError(error.what, where=f"--noise, {path}", remedy=error.remedy) from None
    levels = np.geomspace(low, options.high, LEVELS)
    return NoiseSweep(tuple(specimens), tuple(levels.tolist()), options.draws, options.seed)


def swept(
    folder: Path,
    sweep: NoiseSweep,
    reports: Sequence[CharacterisationReport],
    options: NoiseOptions,
    workers: AbstractContextManager[WorkerPool],
    tell: Callable[[str, float], None],
) -> NoiseSweepReport | None:
    """Make what is missing in `folder` and put all of it together; None: it was one shard of several.

    Raises InputError for parts that are missing or of another sweep; PlatformError; what `tell` raises.
    """
    prepare_parts(folder, sweep)
    if not options.merge:
        with workers as pool:
            make_parts(folder, sweep, options.shard or (1, 1), pool, lambda share: tell("noise sweep", share))
    if options.shard is not None:
        return None
    return noise_report(sweep, parts_of(folder, sweep), reports)


def named(paths: Sequence[Path]) -> list[str]:
    """Names of specimens, each once: those of their files."""
    stems = [path.stem for path in paths]
    return [f"{stem}-{k + 1}" if stems.count(stem) > 1 else stem for k, stem in enumerate(stems)]
