"""The tests keep an order of their own: folders mirror the rooms, what is shared is in kit, no test imports a test."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

from tests.kit.data import ROOT

TESTS = ROOT / "tests"
WITHOUT_A_ROOM = {"benchmarks", "campaigns", "data", "evidence", "kit", "page", "system"}
# Of these a file may import what is neither test nor conftest.
PROGRAMS = {"benchmarks", "campaigns", "evidence", "page", "system"}
MODULES = sorted(TESTS.rglob("*.py"))
FOLDERS = sorted({p.parent for p in MODULES if p.relative_to(TESTS).parts[0] not in WITHOUT_A_ROOM} - {TESTS})


def imported(path: Path) -> Iterator[str]:
    """Modules of the tests that a file imports, in functions too; of `from a import b` a and a.b."""
    package = ["tests", *path.relative_to(TESTS).parts[:-1]]
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else []
            module = ".".join([*above, *([node.module] if node.module else [])])
            found = [module, *(f"{module}.{alias.name}" for alias in node.names)]
        else:
            continue
        yield from (name for name in found if name.split(".")[0] == "tests")


def shared_elsewhere(path: Path) -> Iterator[str]:
    """What a file imports from tests that is neither in kit nor a part of its own program."""
    allowed = {"kit"} | PROGRAMS & {path.relative_to(TESTS).parts[0]}
    for name in imported(path):
        _, *parts = name.split(".")
        if any(part == "conftest" or part.startswith("test_") for part in parts) or {*parts[:1]} - allowed:
            yield f"{path.relative_to(TESTS)} imports {name}"


def test_only_what_is_in_kit_is_shared():
    assert [offence for path in MODULES for offence in shared_elsewhere(path)] == []


def test_folders_mirror_those_of_the_project():
    places = [folder.relative_to(TESTS) for folder in FOLDERS]
    rooms = [(ROOT / place, ROOT / "platform_daemon" / place) for place in places]
    assert [p for p, r in zip(places, rooms, strict=True) if not any((x / "__init__.py").is_file() for x in r)] == []


def test_every_folder_of_tests_is_a_package():
    assert all((folder / "__init__.py").is_file() for folder in {p.parent for p in MODULES})
