"""`python -m tests.benchmarks.command_line`: how long commands take that people wait for, as processor time.

The limits hold on an idle computer on which Python itself starts within 0.05 s: 0.4 s for any help, 1.5 s for the plan
of a measurement.  Processor time hardly depends on what else the computer does; the time on the clock does.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tests.kit.command_words import all_words

COMMAND = Path(sys.executable).with_name("platform-daemon")
REPEATS = 3
HELP_S, PLAN_S = 0.4, 1.5


@dataclass(frozen=True, kw_only=True)
class Times:
    """The shortest of some runs, s."""

    processor_s: float
    clock_s: float


def run_times(command: Sequence[str | Path]) -> Times:
    """User and system time of a process and its children.  Raises CalledProcessError."""
    found = []
    for _ in range(REPEATS):
        before, began = os.times(), time.perf_counter()
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        after, ended = os.times(), time.perf_counter()
        used = after.children_user + after.children_system - before.children_user - before.children_system
        found.append(Times(processor_s=used, clock_s=ended - began))
    return min(found, key=lambda each: each.processor_s)


def main() -> None:
    """Print the times; a star marks what takes longer than its limit."""
    plan = ["measure", "--resonator", "jewel", "--dry-run"]
    cases = [("python -c pass", [sys.executable, "-c", "pass"], HELP_S)]
    cases += [(" ".join([*words, "--help"]), [COMMAND, *words, "--help"], HELP_S) for words in all_words()]
    cases.append((" ".join(plan), [COMMAND, *plan], PLAN_S))
    print(f"{'processor':>9} {'clock':>7} {'limit':>6}  command, s")
    for name, command, limit_s in cases:
        found = run_times(command)
        mark = "*" if found.processor_s > limit_s else " "
        print(f"{found.processor_s:9.3f}{mark}{found.clock_s:7.3f} {limit_s:6.2f}  {name}", flush=True)


if __name__ == "__main__":
    main()
