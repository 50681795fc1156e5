"""Tasks for workers: they must be importable where the workers are."""

from __future__ import annotations

import os
import signal
import time
from dataclasses import dataclass

from drivers.errors import DeviceFault


@dataclass(frozen=True)
class Sum:
    """Adds up, and says how far it is."""

    numbers: tuple[int, ...]

    def __call__(self, tell):
        total = 0
        for done, number in enumerate(self.numbers, start=1):
            total += number
            tell(done, "adding")
        return total


def pid():
    return os.getpid()


def nice():
    return os.nice(0)


def sleeps(seconds):
    time.sleep(seconds)


def holds(megabytes):
    return len(bytearray(megabytes * 1_000_000))


KEPT = []


def keeps(megabytes):
    KEPT.append(bytearray(megabytes * 1_000_000))
    for page in range(0, len(KEPT[-1]), 4096):
        KEPT[-1][page] = 1
    return len(KEPT[-1])


def dies():
    os.kill(os.getpid(), signal.SIGKILL)


def fails():
    raise DeviceFault("stumbled", where="here", why="there was a stone", remedy="lift your feet")


def breaks():
    return {}["nothing"]


def cannot_be_sent():
    return lambda: None
