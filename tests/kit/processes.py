"""Processes by what started them."""

from __future__ import annotations

from pathlib import Path


class NoSuchChild(AssertionError):
    """No child has these words in its command."""


def child_of(parent: int, *words: str) -> int:
    """The id of the child of any thread of `parent` whose command has these words.  Raises NoSuchChild."""
    for task in Path(f"/proc/{parent}/task").iterdir():
        for pid in (task / "children").read_text().split():
            said = Path(f"/proc/{pid}/cmdline").read_text()
            if all(word in said for word in words):
                return int(pid)
    raise NoSuchChild(f"{parent} has no child {' '.join(words)}")
