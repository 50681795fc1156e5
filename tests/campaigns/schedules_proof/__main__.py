"""python -m tests.campaigns.schedules_proof --page docs/evidence/schedules-proof.md"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

from tests.campaigns.schedules_proof.kills import Survived, daemon_kills, scheduler_kills
from tests.campaigns.schedules_proof.years import Told, Years

PAGE = Path(__file__).with_name("page.txt")


def main() -> int:
    """Exit code 1 if anything is wrong."""
    parser = argparse.ArgumentParser(prog="python -m tests.campaigns.schedules_proof", description=__doc__)
    parser.add_argument("--years", type=float, default=10.0)
    parser.add_argument("--step-s", type=float, default=2400.0, help="between two steps of the scheduler, on average")
    parser.add_argument("--kills", type=int, default=1000, help="of the scheduler alone")
    parser.add_argument("--daemon-kills", type=int, default=100)
    parser.add_argument("--page", type=Path)
    asked = parser.parse_args()
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        told = Years(Path(folder), asked.years, 1, asked.step_s).run()
    took = time.monotonic() - began
    print(sum(told.instants.values()), "instants,", len(told.wrong), "wrong", flush=True)
    deaths = {}
    for name, kill, count in (("the scheduler alone", scheduler_kills, asked.kills),
                              ("a daemon", daemon_kills, asked.daemon_kills)):  # fmt: skip
        with tempfile.TemporaryDirectory() as folder:
            deaths[name] = kill(Path(folder), count)
        found = deaths[name]
        print(f"{name}: {found.kills} kills, {found.instants} instants, {len(found.wrong)} wrong", flush=True)
    if asked.page is not None:
        asked.page.write_text(page(told, deaths, asked.years, asked.step_s, took), encoding="utf-8")
    wrong = [*told.wrong, *(each for found in deaths.values() for each in found.wrong)]
    print(*wrong, f"{len(wrong)} wrong", sep="\n")
    return int(bool(wrong))


def page(told: Told, deaths: dict[str, Survived], years: float, step_s: float, took: float) -> str:
    """The document."""
    kills = [
        f"| {name} | {d.kills} | {d.instants} | {_counted(d.states)} | {len(d.wrong)} |" for name, d in deaths.items()
    ]
    wrong = [*told.wrong, *(each for found in deaths.values() for each in found.wrong)]
    return PAGE.read_text().format(
        years=years,
        step=step_s,
        took=took,
        instants="\n".join(f"| {name} | {count} |" for name, count in told.instants.items()),
        struck="\n".join(f"| {name} | {count} |" for name, count in sorted(told.struck.items())),
        states=_counted(told.states),
        kills="\n".join(kills),
        wrong="\n".join(f"* {each}" for each in wrong) or "Nothing.",
    )


def _counted(states: dict[str, int]) -> str:
    return ", ".join(f"{count} {name}" for name, count in sorted(states.items()))


if __name__ == "__main__":
    sys.exit(main())
