"""Two labs in turn: the next daemon starts on one while what is left of the last one ends on the other.

Each has ports, devices, data and state of its own; only one of them measures at a time, and nothing starts while times
are taken.
"""

from __future__ import annotations

from pathlib import Path

from tests.campaigns.crash.bench import Bench

ROUNDS = 4
"""Rounds of strikes before both labs are made anew."""


class Pair:
    """bench: the one that is struck."""

    def __init__(self, folder: Path, seed: int) -> None:
        self._benches = []
        for k in range(2):
            own = folder / f"lab{k}"
            own.mkdir()
            self._benches.append(Bench(own, seed + 10_000 * k))

    @property
    def bench(self) -> Bench:
        """Of the next strike."""
        return self._benches[0]

    def next_starts(self) -> None:
        """The daemon that will be struck next begins to start.  Idempotent."""
        self._benches[1].start_soon()

    def change(self) -> None:
        """The other one is struck next."""
        self._benches.reverse()

    def end(self) -> None:
        """Daemons and labs end."""
        for each in self._benches:
            each.end()
