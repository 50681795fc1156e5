"""python -m tests.campaigns.crash --each 200 --page docs/evidence/crash.md

Every strike in turn, round by round.  The journal (JSON lines) lets an interrupted campaign go on.  A strike mostly
waits: several lanes, each with labs and a journal of its own, are over sooner.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

from tests.campaigns.crash import page
from tests.campaigns.crash.bench import NotThere, go_ahead
from tests.campaigns.crash.pair import ROUNDS, Pair
from tests.campaigns.crash.strike import Came, strike
from tests.campaigns.crash.strikes import STRIKES, Strike
from tests.kit.processes import NoSuchChild


def main() -> int:
    """Exit code 1 if an output stayed on, power met the receiver, or a promise was not kept."""
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # `nohup` would have every daemon ignore it, too
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--each", type=int, default=200, help="how often every kind of strike is done")
    parser.add_argument("--only", default="", help="only strikes whose name matches this regular expression")
    parser.add_argument("--minutes", type=float, default=float("inf"), help="stop after so long")
    parser.add_argument("--journal", type=Path, default=Path("crash.jsonl"))
    parser.add_argument("--page", type=Path)
    parser.add_argument("--lanes", type=int, default=1, help="campaigns at once, which share the strikes")
    parser.add_argument("--seed", type=int, default=1, help="of the labs")
    asked = parser.parse_args()
    go_ahead()
    if asked.lanes > 1:
        done = _in_lanes(asked)
    else:
        strikes = [s for s in STRIKES if re.search(asked.only, s.name)]
        done = campaign(strikes, asked.each, asked.journal, asked.minutes * 60, asked.seed)
    if asked.page is not None:
        asked.page.write_text(page.text(done, len(os.sched_getaffinity(0))), encoding="utf-8")
    bad = [*(f"{d.name}, in {d.moment}: {d.missed}, met {d.met}" for d in done if d.missed or d.met)]
    bad += page.too_slow(done)
    took = [d.wall_s for d in done if d.wall_s is not None]
    print(*bad, f"{len(done)} strikes, {len(bad)} complaints", sep="\n")
    if took:
        print(f"{sum(took) / len(took):.2f} s a strike, of {len(took)}")
    return int(bool(bad))


def _in_lanes(asked: argparse.Namespace) -> list[Came]:
    """The strikes of all lanes, each of which is a process of its own: one lab holds up no other."""
    journals = [asked.journal.with_suffix(f".{lane}{asked.journal.suffix}") for lane in range(asked.lanes)]
    shares = [(asked.each + lane) // asked.lanes for lane in range(asked.lanes)]
    lanes = []
    for lane, (journal, share) in enumerate(zip(journals, shares, strict=True)):
        options = {"journal": journal, "only": asked.only, "each": share, "minutes": asked.minutes}
        options["seed"] = asked.seed + 100_000 * lane
        said = [f"--{name}={value}" for name, value in options.items()]
        lanes.append(subprocess.Popen([sys.executable, "-m", "tests.campaigns.crash", *said]))
    for lane in lanes:
        lane.wait()
    return [came for journal in journals for came in _of(journal)]


def _of(journal: Path) -> list[Came]:
    return [Came(**json.loads(line)) for line in journal.read_text().splitlines()] if journal.exists() else []


def campaign(strikes: list[Strike], each: int, journal: Path, seconds: float, seed: int) -> list[Came]:
    """All strikes of the journal, those that are done now among them."""
    done = _of(journal)
    counts, until = Counter(d.name for d in done), time.monotonic() + seconds
    while time.monotonic() < until and any(counts[s.name] < _times(s, each) for s in strikes):
        with tempfile.TemporaryDirectory() as folder:
            pair = Pair(Path(folder), seed=len(done) + seed)
            try:
                for what in _turns(strikes, each, counts):
                    came = None if time.monotonic() > until else _one(pair, what, counts[what.name])
                    if came is None:
                        break
                    counts[what.name] += 1
                    done.append(came)
                    with journal.open("a") as file:
                        file.write(json.dumps(asdict(came)) + "\n")
            finally:
                pair.end()
    return done


def _turns(strikes: list[Strike], each: int, counts: Counter[str]) -> Iterator[Strike]:
    """Those that are missing, as many rounds as one pair of labs serves."""
    for _ in range(ROUNDS):
        yield from _spread([s for s in strikes if counts[s.name] < _times(s, each)])


def _times(strike: Strike, each: int) -> int:
    return math.ceil(each / strike.among)


def _spread(strikes: list[Strike]) -> list[Strike]:
    """A hardware process that dies soon after its start waits before the next one: others come in between."""
    found = [s for s in strikes if s.ends == "nothing"]
    dying = [s for s in strikes if s.ends == "hardware"]
    between = len(found) // max(1, len(dying)) + 1
    for k, each in enumerate(dying):
        found.insert((k + 1) * between - 1, each)
    return [*found, *(s for s in strikes if s.ends == "daemon")]


def _one(pair: Pair, what: Strike, number: int) -> Came | None:
    """None: the moment did not come; nothing was struck then."""
    moment, bench = what.moments[number % len(what.moments)], pair.bench
    try:
        came = strike(bench, what, moment, pair.next_starts)
        if what.ends == "daemon":
            pair.change()
    except (NotThere, NoSuchChild) as error:
        print(f"{what.name}: {error}", file=sys.stderr, flush=True)
        return None
    except Exception as error:  # a broken trial counts against us
        came = Came(what.name, moment, missed=[f"the trial broke: {type(error).__name__}: {error}"])
        bench.stop_daemon()
    times = [came.power_s, came.amplifier_s, came.all_s, came.late_s, came.wall_s]
    print(what.name, moment, *("-" if t is None else f"{t:.3f}" for t in times), came.missed, came.met, flush=True)
    return came


if __name__ == "__main__":
    sys.exit(main())
