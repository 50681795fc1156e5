"""`make install` takes any Python from 3.11 on."""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

from tests.kit.data import ROOT

CANDIDATES = ("python3.14", "python3.13", "python3.12", "python3.11", "python3")


def make(folder: Path, *arguments: str, usable: tuple[str, ...]) -> subprocess.CompletedProcess[str]:
    """Run make in a copy of what it needs, with candidates on the path of which only some run."""
    path = folder / "bin"
    path.mkdir()
    for name in CANDIDATES:
        script = f'exec "{sys.executable}" "$@"' if name in usable else f"echo {name}: not installed >&2; exit 127"
        (path / name).write_text(f"#!/bin/sh\n{script}\n")
        (path / name).chmod(0o755)
    for name in ("Makefile", "pyproject.toml", "constraints.txt"):
        shutil.copy(ROOT / name, folder)
    packages = Path("platform_daemon", "features", "page", "package-lock.json")
    (folder / packages).parent.mkdir(parents=True)
    shutil.copy(ROOT / packages, folder / packages)
    environment = {k: v for k, v in os.environ.items() if k not in {"PYTHON", "MAKEFLAGS", "MFLAGS", "MAKELEVEL"}}
    environment["PATH"] = f"{path}{os.pathsep}{os.environ['PATH']}"
    return subprocess.run(
        ["make", *arguments], check=False, cwd=folder, env=environment, capture_output=True, text=True
    )


def test_the_newest_python_that_runs_is_chosen(tmp_path):
    shown = make(tmp_path, "--eval", "show: ; @echo $(PYTHON)", "show", usable=("python3.12", "python3.11", "python3"))
    assert (shown.returncode, shown.stdout, shown.stderr) == (0, "python3.12\n", "")


def test_without_a_python_from_3_11_on_the_installation_ends_with_one_line(tmp_path):
    refused = make(tmp_path, "install", usable=())
    assert refused.returncode == 2
    said = [line for line in refused.stderr.splitlines() if not line.startswith("make")]
    assert said == ["Python 3.11 or newer is needed: install it, or run make with PYTHON=/path/to/python3"]
    assert not (tmp_path / ".venv").exists()


def test_a_python_that_is_too_old_is_refused_before_anything_is_installed(tmp_path):
    old = tmp_path / "old-python"
    old.write_text("#!/bin/sh\nexit 1\n")
    old.chmod(0o755)
    refused = make(tmp_path, "install", f"PYTHON={old}", usable=CANDIDATES)
    assert refused.returncode == 2
    assert "Python 3.11 or newer is needed" in refused.stderr
    assert not (tmp_path / ".venv").exists()


def test_without_a_browser_and_a_network_the_tests_of_the_page_end_with_one_line(tmp_path, monkeypatch):
    tools = tmp_path / "tools"
    tools.mkdir()
    for name in ("make", "tail"):
        (tools / name).symlink_to(shutil.which(name))
    apt = tools / "apt-get"
    apt.write_text("#!/bin/sh\n[ $1 = update ] || { echo 'E: Unable to locate package chromium' >&2; exit 100; }\n")
    apt.chmod(0o755)
    monkeypatch.setenv("PATH", str(tools))
    installed = tmp_path / ".venv" / ".installed"
    installed.parent.mkdir()
    installed.touch()
    later = time.time() + 60  # than what it depends on, which is copied now
    os.utime(installed, (later, later))
    refused = make(tmp_path, "test-page", usable=())
    assert refused.returncode == 2
    (said,) = (line for line in refused.stderr.splitlines() if not line.startswith("make"))
    assert "apt (E: Unable to locate package chromium): install it so that `chromium` is on the path" in said
    assert refused.stdout == ""


def test_what_the_makefile_imports_is_there():
    lines = [line for line in (ROOT / "Makefile").read_text().splitlines() if "$(BIN)/python -c '" in line]
    imports = [re.search(r"-c '((?:from \S+ )?import [\w, ]+)", line)[1] for line in lines]
    assert imports
    for each in imports:
        subprocess.run([sys.executable, "-c", each], check=True, cwd=ROOT, timeout=60)


def test_the_programs_that_the_makefile_runs_are_there():
    names = set(re.findall(r"\$\(BIN\)/python -m (\w[\w.]*)", (ROOT / "Makefile").read_text())) - {"sphinx", "venv"}
    assert names
    assert [name for name in names if importlib.util.find_spec(name) is None] == []
