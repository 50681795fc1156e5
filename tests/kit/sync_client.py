"""`python -m tests.kit.sync_client`: write platform_daemon/client/sync from platform_daemon/client/aio."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import platform_daemon

FOLDER = Path(platform_daemon.__path__[0]) / "client"
SOURCE, TARGET = FOLDER / "aio", FOLDER / "sync"
RULES = (
    (r"await asyncio\.sleep", "time.sleep"),
    (r"^import asyncio\n", "import time\n"),
    (r"\basync (def|with|for)\b", r"\1"),
    (r"\bawait ", ""),
    (r"\bAsyncGenerator\[(\w+), None\]", r"Generator[\1, None, None]"),
    (r"\b(_?)Async(?=[A-Z])", r"\1"),
    (r"\basynccontextmanager\b", "contextmanager"),
    (r"__a(enter|exit)__", r"__\1__"),
    (r"\ba(close|closing|read)\b", r"\1"),
    (r"\baiter_raw\b", "iter_raw"),
)


def converted(text: str) -> str:
    """The source of a module without async."""
    for pattern, replacement in RULES:
        text = re.sub(pattern, replacement, text, flags=re.MULTILINE)
    return text.replace("import time\nimport time\n", "import time\n")


def made() -> dict[str, str]:
    """The modules of the synchronous client by name, formatted as all others are."""
    return {source.name: _tidy(converted(source.read_text()), source.name) for source in sorted(SOURCE.glob("*.py"))}


def _tidy(text: str, name: str) -> str:
    for command in (("check", "--select", "I,UP028,C416", "--fix", "--unsafe-fixes", "--quiet"), ("format",)):
        words = [sys.executable, "-m", "ruff", *command, "--stdin-filename", str(TARGET / name), "-"]
        text = subprocess.run(words, input=text, capture_output=True, text=True, check=True).stdout
    seen: set[str] = set()
    lines = []
    for line in text.splitlines():  # `asyncio` and `time` have become one
        if line == "import time" and line in seen:
            continue
        seen.add(line)
        lines.append(line)
    return "\n".join(lines) + "\n" if lines else ""


if __name__ == "__main__":
    TARGET.mkdir(exist_ok=True)
    for name, text in made().items():
        (TARGET / name).write_text(text)
