"""python -m tests.campaigns.interlock --page docs/evidence/interlock.md"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter, defaultdict
from pathlib import Path

from tests.campaigns.interlock.bench import WIRINGS
from tests.campaigns.interlock.campaign import Found, run
from tests.campaigns.interlock.mutants import MUTANTS

PAGE = Path(__file__).with_name("page.txt")
MUTANT_STEPS = 10_000


def main() -> int:
    """Exit code 1 if something was broken, or a planted mistake not found."""
    parser = argparse.ArgumentParser(prog="python -m tests.campaigns.interlock", description=__doc__)
    parser.add_argument("--steps", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--page", type=Path)
    asked = parser.parse_args()
    began = time.monotonic()
    found = run(asked.steps, asked.seed)
    took = time.monotonic() - began
    print(f"{found.steps} steps in {took:.0f} s: {found.why or 'nothing broken'}", flush=True)
    for name, times, how in _visits(found):
        print(f"{times:8d}  {name}: {how}")
    mutants = {mutant.name: run(MUTANT_STEPS, asked.seed, mutant) for mutant in MUTANTS}
    for name, each in mutants.items():
        print(f"{name}: {each.why or 'NOT FOUND'} ({each.steps} steps)", flush=True)
    if asked.page is not None:
        asked.page.write_text(page(found, mutants, took), encoding="utf-8")
    return int(bool(found.why) or not all(each.why for each in mutants.values()))


def page(found: Found, mutants: dict[str, Found], took: float) -> str:
    """The document."""
    return PAGE.read_text().format(
        steps=found.steps,
        broken=f"broken: {found.why}" if found.why else "nothing broken",
        took=took,
        platforms=", ".join(WIRINGS),
        visits="\n".join(f"| {name} | {times} | {how} |" for name, times, how in _visits(found)),
        most=MUTANT_STEPS,
        mutants="\n".join(f"| {n} | {f.steps if f.why else 'not found'} | {f.why[:150]} |" for n, f in mutants.items()),
    )


def _visits(found: Found) -> list[tuple[str, int, str]]:
    steps: dict[str, Counter[str]] = defaultdict(Counter)
    for (step, ended), times in found.visits.items():
        steps[step][ended] += times
    return [
        (step, ended.total(), ", ".join(f"{times} {how}" for how, times in ended.most_common()))
        for step, ended in sorted(steps.items())
    ]


if __name__ == "__main__":
    sys.exit(main())
