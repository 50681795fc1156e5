"""The words by which each command is called."""

from __future__ import annotations

from platform_daemon.cli.main import UNLISTED, commands, load


def all_words() -> list[list[str]]:
    """Words of every command: a group's own, and those of the commands in it."""
    found: list[list[str]] = [[]]
    for name in (*commands(), *UNLISTED):
        inner = getattr(load(name), "commands", {})
        found += [name.split(), *([*name.split(), each] for each in inner if (name, each) != ("bench", "fit"))]
    return found
