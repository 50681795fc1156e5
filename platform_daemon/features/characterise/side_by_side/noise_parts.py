"""A noise sweep cut into parts, each a file of its own, so that shards and a killed run leave what they have made."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from dataclasses import dataclass, replace
from pathlib import Path

from pydantic import ValidationError

from drivers.errors import InputError, PlatformError
from platform_daemon import __version__
from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.state.durable import write_file
from platform_daemon.features.fit.batch.executors import WorkerPool
from platform_daemon.features.fit.batch.part import InputFile
from platform_daemon.features.fit.fit_request import FitSettings

from .noise_fits import NoisyShots, fit_noisy_shots
from .noise_schema import NoisePart, NoisePlan

_FITS = 300  # of a part: seconds of work, so that neither Dask nor the disk counts


@dataclass(frozen=True)
class NoiseSweep:
    """A sweep over the shots of several specimens.

    Attributes:
        specimens: recording, and settings of its N50 fits with the frames of its shots.
        levels: A m^2/s; draws, seed: see NoisyShots.
    """

    specimens: tuple[tuple[Path, FitSettings], ...]
    levels: tuple[float, ...]
    draws: int
    seed: int

    @property
    def parts(self) -> list[NoisyShots]:
        """In the order of the specimens, independent of who makes them."""
        size = max(1, _FITS // (len(self.levels) * self.draws))
        found = []
        for k, (path, settings) in enumerate(self.specimens):
            frames = settings.frames or ()
            for first in range(0, len(frames), size):
                some = replace(settings, frames=frames[first : first + size])
                found.append(NoisyShots(InputFile(path), some, self.levels, self.draws, self.seed, k))
        return found

    @property
    def plan(self) -> NoisePlan:
        """What its parts belong to."""
        return NoisePlan(
            software_version=__version__,
            specimens=tuple(_digest(path, settings) for path, settings in self.specimens),
            levels_am2_per_s=self.levels,
            draws=self.draws,
            seed=self.seed,
            parts=len(self.parts),
        )


def _digest(path: Path, settings: FitSettings) -> str:
    with path.open("rb") as file:
        content = hashlib.file_digest(file, "sha256").hexdigest()
    how = f"{settings.model!r} {settings.terms} {settings.fixed} {settings.frames}"
    return hashlib.sha256(f"{content} {how}".encode()).hexdigest()[:16]


def prepare_parts(folder: Path, sweep: NoiseSweep) -> None:
    """Make the folder of the parts.  Raises InputError if it holds those of another sweep; StorageError."""
    file = folder / "plan.json"
    folder.mkdir(parents=True, exist_ok=True)
    if not file.exists():
        write_file(file, to_json(sweep.plan, indent=1).encode())
        return
    remedy = "name another folder, or give the same recordings and options"
    try:
        before = NoisePlan.model_validate_json(file.read_bytes())
    except ValidationError:
        raise InputError("is no plan of a noise sweep", where=str(file), remedy=remedy) from None
    now = sweep.plan
    named = [name for name in NoisePlan.model_fields if getattr(before, name) != getattr(now, name)]
    if named:
        raise InputError("is of another noise sweep", where=str(file), why=f"{', '.join(named)} differ", remedy=remedy)


def make_parts(
    folder: Path, sweep: NoiseSweep, shard: tuple[int, int], workers: WorkerPool, tell: Callable[[float], None]
) -> None:
    """Make what is missing of a shard (number from 1, of so many), and keep each part as it is done.

    A part of a worker that is lost is made again by Dask.  Raises PlatformError.
    """
    number, count = shard
    mine = [k for k in range(len(sweep.parts)) if k % count == number - 1]
    todo = [k for k in mine if not _file(folder, k).is_file()]
    parts, running, waiting = sweep.parts, dict[Future[NoisePart], int](), list(reversed(todo))
    try:
        while waiting or running:
            while waiting and len(running) < 2 * workers.count:
                k = waiting.pop()
                running[workers.executor.submit(fit_noisy_shots, _as_sent(parts[k], workers))] = k
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                k = running.pop(future)
                write_file(_file(folder, k), to_json(_result(future, parts[k])).encode())
            tell(1.0 - (len(waiting) + len(running)) / len(mine))
    finally:
        for future in running:
            future.cancel()


def _result(future: Future[NoisePart], part: NoisyShots) -> NoisePart:
    """Raises PlatformError, also for workers that died or were lost."""
    try:
        return future.result()
    except PlatformError:
        raise
    except (Exception, CancelledError) as error:
        why = f"{type(error).__name__}: {error}"
        remedy = "run the same command again: the parts that are made stay"
        raise PlatformError(
            "a part of the sweep was lost", where=str(part.source.path), why=why, remedy=remedy
        ) from None


def _as_sent(part: NoisyShots, workers: WorkerPool) -> NoisyShots:
    if not workers.send_content:
        return part
    return replace(part, source=InputFile(part.source.path, part.source.path.read_bytes()))


def parts_of(folder: Path, sweep: NoiseSweep) -> list[NoisePart]:
    """All parts.  Raises InputError if one is missing or cannot be read."""
    count = len(sweep.parts)
    missing = [k for k in range(count) if not _file(folder, k).is_file()]
    if missing:
        told = ", ".join(str(k) for k in missing[:10]) + (", ..." if len(missing) > 10 else "")
        remedy = "run the shards that are missing, or leave --merge out, which makes what is missing"
        raise InputError(f"{len(missing)} of {count} parts are missing", where=str(folder), why=told, remedy=remedy)
    return [_read(_file(folder, k)) for k in range(count)]


def _read(file: Path) -> NoisePart:
    try:
        return NoisePart.model_validate_json(file.read_bytes())
    except ValidationError:
        remedy = "delete it: it is made again"
        raise InputError("is no part of a noise sweep", where=str(file), remedy=remedy) from None


def _file(folder: Path, part: int) -> Path:
    return folder / f"part-{part:05d}.json"
