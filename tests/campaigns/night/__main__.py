"""python -m tests.campaigns.night --minutes 60 --page docs/evidence/night.md"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
from collections import Counter
from datetime import datetime
from pathlib import Path

import numpy as np

from tests.campaigns.night.night import EVERY_S, SHOTS, Night, cores, night
from tests.campaigns.night.story import AFTER_S, contradictions

PAGE = Path(__file__).with_name("page.txt")


def main() -> int:
    """Exit code 1 if anybody tells another story."""
    parser = argparse.ArgumentParser(prog="python -m tests.campaigns.night", description=__doc__)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--no-trip", action="store_true", help="the amplifier does not trip for good in the end")
    parser.add_argument("--keep", type=Path, help="work in this folder, and leave it")
    parser.add_argument("--page", type=Path)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        place = asked.keep or Path(folder)
        place.mkdir(exist_ok=True)
        found = night(place, asked.minutes * 60, asked.seed, last_trips=not asked.no_trip)
    wrong = contradictions(found)
    if asked.page is not None:
        asked.page.write_text(_page(found, wrong, last_trips=not asked.no_trip), encoding="utf-8")
    print(*_counts(found), *wrong, f"{len(wrong)} contradictions", sep="\n")
    return int(bool(wrong))


def _counts(found: Night) -> list[str]:
    frames = [info.verdict for each in found.recordings.values() for info in each.frame_info]
    fits = [each for each in found.events if each["what"]["kind"] == "fit"]
    rows = {
        "due instants, by state": _counted(Counter(row["state"] for row in found.rows)),
        "jobs, by state": _counted(Counter(job["state"] for job in found.jobs.values())),
        "recordings": str(len(found.recordings)),
        "shots stored, by verdict": _counted(Counter(frames)),
        "shots played": str(found.played),
        "on-line fits told": str(len(fits)),
        "fits by the calendar, by state": _counted(Counter(row["state"] for row in found.analyses)),
        "alarms raised": _counted(Counter(each["name"].partition(":")[0] for each in found.called)),
        "from a shot on the disk to its fit": _delays(found),
        "alarms that stand in the morning": ", ".join(_alarm(each, found.names) for each in found.standing) or "none",
    }
    return [f"| {name} | {value} |" for name, value in rows.items()]


def _delays(found: Night) -> str:
    """And how many fits came only when the next shot was on the disk, too."""
    shots = {
        (each["what"]["job"], each["what"]["shot"]): datetime.fromisoformat(each["at"])
        for each in found.events
        if each["what"]["kind"] == "shot"
    }
    took, late = [], 0
    for each in found.events:
        job, shot = each["what"].get("job"), each["what"].get("shot")
        if each["what"]["kind"] == "fit" and (job, shot) in shots:
            at = datetime.fromisoformat(each["at"])
            took.append((at - shots[job, shot]).total_seconds())
            late += (job, shot + 1) in shots and at > shots[job, shot + 1]
    middle, last = np.median(took), np.quantile(took, 0.99)
    return (
        f"{middle:.2f} s (median), {last:.2f} s (99 %), {max(took):.2f} s at most; "
        f"{late} of {len(took)} after the next shot was on the disk"
    )


def _alarm(name: str, schedules: dict[str, str]) -> str:
    """With the schedule's name in place of its id, and without the ids of jobs."""
    kind, _, of = name.partition(":")
    return f"{kind}: {schedules.get(of, of.partition('-')[0])}"


def _page(found: Night, wrong: list[str], *, last_trips: bool) -> str:
    done = Counter(blow.name for blow in found.blows)
    struck = Counter(blow.name for blow in found.blows if blow.struck)
    reasons = Counter(_short(row["reason"]) for row in found.rows if row["state"] != "run")
    return PAGE.read_text().format(
        every=EVERY_S,
        shots=SHOTS,
        after=AFTER_S,
        trip=" In the last tenth the amplifier trips, and is not reset." if last_trips else "",
        seconds=found.ended - found.began,
        cores=cores(),
        counts="\n".join(_counts(found)),
        blows="\n".join(f"| {name} | {count} | {struck[name]} |" for name, count in sorted(done.items())),
        reasons="\n".join(f"| {name} | {count} |" for name, count in reasons.most_common()),
        wrong="\n".join(f"* {each}" for each in wrong) or "None.",
    )


def _short(reason: str) -> str:
    """Without what differs from one time to the next."""
    reason = re.sub(r"/\S*/(\w+):", r"\1:", reason)
    text = re.sub(r"acquisition-\S+", "acquisition-...", re.sub(r"\d+(\.\d+)?", "#", reason.split(" Remedy")[0]))
    return text[:150].replace("|", "/").replace("\n", " ")


def _counted(counts: Counter[str]) -> str:
    return ", ".join(f"{count} {name}" for name, count in sorted(counts.items())) or "none"


if __name__ == "__main__":
    sys.exit(main())
