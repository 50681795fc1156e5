"""python -m tests.campaigns.crash --each 200 --page docs/crash.md

Every strike in turn, round by round.  The journal (JSON lines) lets an interrupted campaign go on.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from collections import Counter
from dataclasses import asdict
from pathlib import Path

from tests.kit.processes import NoSuchChild

from . import page
from .bench import Bench, NotThere
from .strike import Came, strike
from .strikes import STRIKES, Strike


def main() -> int:
    """Exit code 1 if an output stayed on, power met the receiver, or a promise was not kept."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--each", type=int, default=200, help="how often every strike is done")
    parser.add_argument("--only", default="", help="only strikes whose name contains this")
    parser.add_argument("--minutes", type=float, default=float("inf"), help="stop after so long")
    parser.add_argument("--journal", type=Path, default=Path("crash.jsonl"))
    parser.add_argument("--page", type=Path)
    asked = parser.parse_args()
    done = campaign([s for s in STRIKES if asked.only in s.name], asked.each, asked.journal, asked.minutes * 60)
    if asked.page is not None:
        asked.page.write_text(page.text(done, len(os.sched_getaffinity(0))), encoding="utf-8")
    bad = [*(f"{d.name}, in {d.moment}: {d.missed}, met {d.met}" for d in done if d.missed or d.met)]
    bad += page.too_slow(done)
    print(*bad, f"{len(done)} strikes, {len(bad)} complaints", sep="\n")
    return int(bool(bad))


def campaign(strikes: list[Strike], each: int, journal: Path, seconds: float) -> list[Came]:
    """All strikes of the journal, those that are done now among them."""
    done = [Came(**json.loads(line)) for line in journal.read_text().splitlines()] if journal.exists() else []
    counts, until = Counter(d.name for d in done), time.monotonic() + seconds
    while time.monotonic() < until and any(counts[s.name] < each for s in strikes):
        with tempfile.TemporaryDirectory() as folder:  # a new lab every round
            bench = Bench(Path(folder), seed=len(done) + 1)
            try:
                for what in [s for s in strikes if counts[s.name] < each and time.monotonic() < until]:
                    came = _one(bench, what, counts[what.name])
                    if came is None:
                        break
                    counts[what.name] += 1
                    done.append(came)
                    with journal.open("a") as file:
                        file.write(json.dumps(asdict(came)) + "\n")
            finally:
                bench.end()
    return done


def _one(bench: Bench, what: Strike, number: int) -> Came | None:
    """None: the moment did not come; nothing was struck then."""
    moment = what.moments[number % len(what.moments)]
    try:
        came = strike(bench, what, moment)
    except (NotThere, NoSuchChild) as error:
        print(f"{what.name}: {error}", file=sys.stderr, flush=True)
        return None
    except Exception as error:  # a broken trial counts against us
        came = Came(what.name, moment, missed=[f"the trial broke: {type(error).__name__}: {error}"])
        bench.stop_daemon()
    times = [came.power_s, came.amplifier_s, came.all_s, came.late_s]
    print(what.name, moment, *("-" if t is None else f"{t:.3f}" for t in times), came.missed, came.met, flush=True)
    return came


if __name__ == "__main__":
    sys.exit(main())
