"""Small recordings for batches: the example files, copied."""

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from pydantic import BaseModel

from tests.kit.data import DATA

WINDOW_S = 0.1


def copies(folder: Path, count: int) -> list[Path]:
    """Jewel and thread in turn."""
    return _made(folder, count, shutil.copy)


def links(folder: Path, count: int) -> list[Path]:
    """The same to read only, and cheap in any number."""
    return _made(folder, count, os.symlink)


def _made(folder: Path, count: int, make: Callable[[Path, Path], object]) -> list[Path]:
    made = [folder / f"{k:02d}-{('jewel', 'thread')[k % 2]}.h5" for k in range(count)]
    for k, path in enumerate(made):
        make(DATA / f"example_{('jewel', 'thread')[k % 2]}.mmr.h5", path)
    return made


def same(one, other):
    """Equal but for rounding (libraries add up in another order in each process) and for times."""
    if isinstance(one, BaseModel):
        return same(one.model_dump(), other.model_dump())
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(k == "seconds" or same(one[k], other[k]) for k in one)
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(same, one, other))
    return other == (pytest.approx(one, rel=1e-7, abs=1e-12) if isinstance(one, float) else one)
