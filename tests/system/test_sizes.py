"""Files and functions stay small enough to be read at one go."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

from tests.kit.data import ROOT

PACKAGES = ("platform_daemon", "drivers", "sequences", "sim_backend")
LONGEST_FILE, LONGEST_FUNCTION = 400, 80  # lines


def modules() -> Iterator[Path]:
    for package in PACKAGES:
        yield from sorted((ROOT / package).rglob("*.py"))


def test_no_file_is_longer_than_400_lines():
    long = {str(path.relative_to(ROOT)): len(path.read_text().splitlines()) for path in modules()}
    assert len(long) > 300
    assert not {name: lines for name, lines in long.items() if lines > LONGEST_FILE}


def test_no_function_is_longer_than_80_lines():
    long = {}
    for path in modules():
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                long[f"{path.relative_to(ROOT)}: {node.name}"] = (node.end_lineno or 0) - node.lineno + 1
    assert len(long) > 1000
    assert not {name: lines for name, lines in long.items() if lines > LONGEST_FUNCTION}


def test_the_root_of_the_daemon_holds_two_files_and_eleven_rooms():
    root = ROOT / "platform_daemon"
    assert {path.name for path in root.glob("*.py")} == {"__init__.py", "__main__.py"}
    rooms = {"cli", "client", "core", "design", "diagnosis", "estimation", "features", "library", "processes"}
    rooms |= {"uncertainty"}
    assert {path.parent.name for path in root.glob("*/__init__.py")} == rooms | {"testing"}
