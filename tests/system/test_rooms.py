"""What each process loads, and in how few files a feature is named; tests/core/test_registry.py has the registry."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest

import platform_daemon
from platform_daemon.features.registry import FEATURES
from tests.kit.imports import loaded

ROOT = Path(platform_daemon.__file__).parent


@pytest.mark.parametrize(
    "module",
    [
        "platform_daemon.core.hardware.engine",
        "platform_daemon.core.recordings.series_writer",
        "platform_daemon.core.settings",
        "platform_daemon.core.service.local",
        "platform_daemon.processes.hardware_process",
    ],
)
def test_what_the_hardware_process_imports_loads_neither_compiler_nor_pictures_nor_web(module):
    assert loaded(f"import {module}", ("numba", "matplotlib", "fastapi", "scipy.stats")) == []


def test_the_process_for_stop_loads_next_to_nothing():
    code = (
        "import platform_daemon.processes.stop_process;"
        "from platform_daemon.core.web.stop_server import create_stop_api;"
        "from platform_daemon.core.web.network.http_server import running_server;"
        "from platform_daemon.core.service.stopping import Stopper;"
        "from platform_daemon.core.state.tokens import tokens_in"
    )
    heavy = ("numba", "matplotlib", "numpy", "scipy", "h5py", "prometheus_client", "platform_daemon.core.hardware")
    assert loaded(code, heavy) == []


def test_the_web_process_starts_without_compiler_pictures_and_half_of_scipy():
    heavy = ("numba", "matplotlib", "scipy.stats", "scipy.signal", "scipy.optimize")
    code = (
        "import platform_daemon.processes.web_process;"
        "from platform_daemon.core.web.server import feature_routers;"
        "assert list(feature_routers())"
    )
    assert loaded(code, heavy) == []


@pytest.mark.parametrize(
    "words",
    [
        ["measure", "--resonator", "jewel", "--dry-run"],
        ["sweep", "--resonator", "jewel", "--over", "field_ut=100:200:100", "--dry-run"],
        ["outputs-off", "--platform", "simulated"],
    ],
    ids=lambda words: words[0],
)
def test_a_command_that_makes_no_shot_loads_neither_compiler_nor_pictures_nor_web_nor_scipy(
    words, tmp_path, monkeypatch
):
    """The devices are opened and read back, and the plan is checked in full, without what only a shot needs."""
    monkeypatch.chdir(tmp_path)
    code = f"import platform_daemon.cli.main as cli; sys.argv = ['platform-daemon', *{words!r}]; code = run(cli.main)"
    run = "def run(main):\n try: main()\n except SystemExit as end: assert not end.code, end.code"
    heavy = ("numba", "matplotlib", "fastapi", "scipy.signal", "scipy.special", "scipy.optimize", "scipy.constants")
    assert loaded(f"exec({run!r}); {code}", heavy) == []


def test_every_folder_of_the_features_is_one_line_of_the_registry():
    folders = {path.parent.name for path in (ROOT / "features").glob("*/__init__.py")}
    assert folders == set(FEATURES)
    assert len(FEATURES) == len(set(FEATURES))


@pytest.mark.parametrize(("word", "most"), [("self_?test", 8), ("ramp", 12)])
def test_a_feature_is_named_in_few_files_of_the_daemon(word, most):
    """A feature that is named everywhere can be understood nowhere.  The client, with a method for each, is apart."""
    pattern = re.compile(rf"\b\w*{word}\w*\b", re.IGNORECASE)
    daemon = [path for path in ROOT.rglob("*.py") if path.relative_to(ROOT).parts[0] != "client"]
    named = [path for path in daemon if pattern.search(code_of(path))]
    assert len(named) <= most, [str(path.relative_to(ROOT)) for path in named]


@cache
def code_of(path: Path) -> str:
    """The names in a file: what is imported, defined and used, and no text."""
    names = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Name):
            names.append(node.id)
        elif isinstance(node, ast.Attribute):
            names.append(node.attr)
        elif isinstance(node, ast.ImportFrom):
            names += [node.module or "", *(each.name for each in node.names)]
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.append(node.name)
        elif isinstance(node, ast.arg):
            names.append(node.arg)
    return " ".join(names)


def test_the_warm_up_of_the_simulated_platform_loads_what_its_first_shot_imports():
    code = "import sim_backend.backend; from sim_backend.world.warm_up import warm_up"
    needed = ("sim_backend.world.shot", "sim_backend.receive.receiver", "scipy.fft", "numba")
    assert loaded("import sim_backend.backend", needed) == []
    assert loaded(code, needed) == list(needed)
