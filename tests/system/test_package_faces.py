"""Whoever opens a folder of drivers, sequences or the simulated world finds a word on every file in it."""

from __future__ import annotations

import importlib
from pathlib import Path

import pytest

import drivers
import sequences
import sim_backend

FOLDERS = sorted(
    init.parent
    for package in (drivers, sequences, sim_backend)
    for init in Path(package.__path__[0]).rglob("__init__.py")
)
ROOT = Path(drivers.__path__[0]).parent


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: str(folder.relative_to(ROOT)))
def test_the_docstring_of_a_folder_names_every_file_and_folder_in_it_and_no_other(folder: Path) -> None:
    said = importlib.import_module(".".join(folder.relative_to(ROOT).parts)).__doc__ or ""
    there = {p.name for p in folder.glob("*.py")} - {"__init__.py"} | {
        f"{p.parent.name}/" for p in folder.glob("*/__init__.py")
    }
    assert {name for name in there if name not in said} == set()
    listed = {line.split("  ")[0] for line in said.splitlines() if line.split("  ")[0].endswith((".py", "/"))}
    listed = {name for several in listed for name in several.split(", ")}
    assert listed <= there
