"""Each room of the daemon has one face: what other rooms import is what it offers, and it says a sentence on each."""

from __future__ import annotations

import ast
import importlib
import re
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

import platform_daemon

ROOT = Path(platform_daemon.__file__).parent
ROOMS = sorted(p.parent.name for p in ROOT.glob("*/__init__.py"))
FACES = [room for room in ROOMS if room != "cli"]  # the command line is the top: nobody imports it but __main__


def imports(path: Path) -> Iterator[tuple[str, str]]:
    """(module, name) of every import of the daemon in a file, absolute; rooms used as `room.name` too."""
    package = ["platform_daemon", *path.relative_to(ROOT).parts[:-1]]
    tree = ast.parse(path.read_text())
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else []
            module = ".".join([*above, *([node.module] if node.module else [])])
            if module.split(".")[0] == "platform_daemon":
                yield from ((module, alias.name) for alias in node.names)
    rooms = {name for module, name in _plain(tree) if module == "platform_daemon"}
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in rooms:
            yield f"platform_daemon.{node.value.id}", node.attr


def _plain(tree: ast.AST) -> Iterator[tuple[str | None, str]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and not node.level:
            yield from ((node.module, alias.name) for alias in node.names)


def test_what_a_room_offers_is_what_other_rooms_import_and_only_through_its_face():
    used: dict[str, set[str]] = defaultdict(set)
    for path in ROOT.rglob("*.py"):
        own = path.relative_to(ROOT).parts[0]
        for module, name in imports(path):
            parts = module.split(".")
            if len(parts) > 1 and parts[1] != own and parts[1] in FACES:
                assert len(parts) == 2, f"{path} reaches past the face of {parts[1]}: {module}.{name}"
                used[parts[1]].add(name)
    for room in FACES:
        offered = set(importlib.import_module(f"platform_daemon.{room}").__all__)
        assert not offered - used[room], f"{room} offers what nobody imports"
        assert not used[room] - offered, f"{room} does not offer what others import"


@pytest.mark.parametrize("room", FACES)
def test_a_face_says_one_sentence_on_each_name_and_every_name_exists(room):
    face = importlib.import_module(f"platform_daemon.{room}")
    said = dict(re.findall(r"^(\w+): (\S.*)", face.__doc__, re.MULTILINE))
    assert set(said) == set(face.__all__)
    for name in face.__all__:
        assert getattr(face, name) is not None


@pytest.mark.parametrize("room", FACES)
def test_no_name_of_a_face_is_that_of_a_module_in_the_room_but_where_the_face_binds_it_last(room):
    face = importlib.import_module(f"platform_daemon.{room}")
    modules = {p.stem for p in (ROOT / room).glob("*.py")} | {
        p.parent.name for p in (ROOT / room).glob("*/__init__.py")
    }
    for name in modules & set(face.__all__):
        assert "lazy_loader" not in (ROOT / room / "__init__.py").read_text(), name
        assert callable(getattr(face, name))


@pytest.mark.parametrize(
    "module",
    [
        "platform_daemon.engine",
        "platform_daemon.store",
        "platform_daemon.settings",
        "platform_daemon.serving.hardware_process",
    ],
)
def test_what_the_hardware_process_imports_loads_neither_compiler_nor_pictures_nor_web(module):
    heavy = "numba", "matplotlib", "fastapi", "scipy.stats"
    code = f"import sys, {module}; print([m for m in {heavy!r} if m in sys.modules])"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert out.stdout.strip() == "[]"


def test_the_process_for_stop_loads_next_to_nothing():
    heavy = "numba", "matplotlib", "numpy", "scipy", "h5py", "prometheus_client", "platform_daemon.engine"
    made = "from platform_daemon.api import create_stop_api, served; from platform_daemon.link import Stopper"
    code = f"import sys, platform_daemon.serving.stop_process; {made}; from platform_daemon.store import tokens_in"
    found = f"print([m for m in {heavy!r} if m in sys.modules])"
    out = subprocess.run(
        [sys.executable, "-c", f"{code}; {found}"], capture_output=True, text=True, check=True, timeout=60
    )
    assert out.stdout.strip() == "[]"


def test_the_web_process_starts_without_compiler_pictures_and_half_of_scipy():
    heavy = "numba", "matplotlib", "scipy.stats", "scipy.signal", "scipy.optimize"
    code = f"import sys, platform_daemon.serving.web_process; print([m for m in {heavy!r} if m in sys.modules])"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert out.stdout.strip() == "[]"
