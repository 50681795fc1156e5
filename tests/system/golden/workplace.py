"""A folder in which a scenario works, and what it keeps of it."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

from tests.system.golden.structure import structure_text
from tests.system.golden.volatile import Placeholders

TREE = Path(__file__).parents[3]
DATA = TREE / "tests" / "data"
TIMEOUT_S = 900.0  # the first run of a tree compiles kernels


class Workplace:
    """Runs the program in `folder` and keeps what comes out in `kept`, cleaned of volatile values.

    tree: the source tree whose program is run.
    """

    def __init__(self, folder: Path, kept: Path, tree: Path = TREE) -> None:
        folder.mkdir(parents=True)
        kept.mkdir(parents=True)
        self.folder, self.tree = folder, tree
        self._kept = kept
        version = self.run("--version").stdout.strip()
        self._placeholders = Placeholders({folder.resolve(): "<folder>", tree.resolve(): "<tree>"}, version)

    @property
    def environment(self) -> dict[str, str]:
        """That of the program: the tree's code, tables of a fixed width without colours, a user who is nobody."""
        fixed = {"COLUMNS": "120", "NO_COLOR": "1", "TERM": "dumb", "LC_ALL": "C.UTF-8", "TZ": "UTC"}
        fixed |= dict.fromkeys(("LOGNAME", "USER", "LNAME", "USERNAME"), "tester")
        mine = {k: v for k, v in os.environ.items() if not k.startswith("PLATFORM_DAEMON")}
        return {**mine, **fixed, "PYTHONPATH": str(self.tree)}

    def command(self, *arguments: object) -> list[str]:
        """The command line of the program."""
        return [sys.executable, "-m", "platform_daemon", *map(str, arguments)]

    def run(self, *arguments: object) -> subprocess.CompletedProcess[str]:
        """Run a command to its end; nothing is kept."""
        return subprocess.run(
            self.command(*arguments),
            input="", capture_output=True, text=True, timeout=TIMEOUT_S, check=False,
            cwd=self.folder, env=self.environment,
        )  # fmt: skip

    def case(self, name: str, *arguments: object, ordered: bool = True, told: bool = True) -> None:
        """Run a command; keep exit code, lines, and the files that it was told to write as JSON or JSON lines.

        ordered: False if several processes tell of their files as they end; told: False if what it tells are times.
        """
        written = {f: _stamp(self.folder / f) for o, f in pairwise(map(str, arguments)) if o in ("--json", "--jsonl")}
        done = self.run(*arguments)
        lines = [f"$ platform-daemon {' '.join(map(str, arguments))}", f"exit code {done.returncode}"]
        for stream, text in (("stdout", done.stdout), ("stderr", done.stderr)):
            if text.strip() and (stream == "stderr" or (told and not _is_json(text))):
                said = [line.rstrip() for line in text.splitlines() if line.strip()]
                if not ordered:
                    said = sorted(re.sub(r"^\[\d+/", "[<int>/", line) for line in said)
                lines += [f"-- {stream}", *said]
        self.keep(f"{name}.txt", "\n".join(lines) + "\n")
        if _is_json(done.stdout):
            self.keep(f"{name}.stdout.json", done.stdout)
        for name_of, before in written.items():
            path = self.folder / name_of
            if _stamp(path) != before:
                self.keep(f"{name}{path.suffix}", path.read_text())

    def keep(self, name: str, text: str) -> None:
        """Keep a text."""
        path = self._kept / re.sub("[<>]", "", self._placeholders.clean(name))
        if path.exists():
            raise ValueError(f"two cases are called {name}")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(self._placeholders.clean(text), encoding="utf-8")

    def keep_structure(self, name: str, path: Path) -> None:
        """Keep what an HDF5 file is made of."""
        self.keep(f"{name}.txt", structure_text(path))

    def take(self, *sources: str, into: str = ".") -> None:
        """Copy files of tests/data here, so that results name them by a relative path."""
        (self.folder / into).mkdir(parents=True, exist_ok=True)
        for source in sources:
            shutil.copy(DATA / source, self.folder / into / Path(source).name)
            self._placeholders.input(DATA / source)


def _stamp(path: Path) -> int | None:
    return path.stat().st_mtime_ns if path.exists() else None


def _is_json(text: str) -> bool:
    try:
        return isinstance(json.loads(text), dict | list)
    except ValueError:
        return False
