"""The fault campaign: every fault of the catalogue, many times over, on several emulated labs side by side.

    python -m tests.campaigns.faults.campaign --faults 2080 --processes 4 --page docs/evidence/fault-campaign.md

Seeded: fault number k is the same in every run.  The journal (JSON lines) lets an interrupted campaign go on.
"""

from __future__ import annotations

import argparse
import json
import logging
import multiprocessing
import shutil
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import structlog

from tests.campaigns.faults import page
from tests.campaigns.faults.bench import Bench
from tests.campaigns.faults.catalogue import cells
from tests.campaigns.faults.trial import Seen, as_record, draw, run
from tests.kit.watch import Watch

STILL_S, TOO_LATE = 0.25, "the host was too late"
REPEATS = 5


def done_before(journal: Path, seed: int) -> dict[int, dict[str, Any]]:
    """Records by number of the fault; those of another seed or catalogue, and unexpected ones, do not count."""
    return {r["index"]: r for r in last_records(journal, seed) if not r["complaints"]}


def last_records(journal: Path, seed: int) -> list[dict[str, Any]]:
    """The last record of every fault."""
    found = {}
    for line in journal.read_text().splitlines() if journal.exists() else ():
        record = json.loads(line)
        if record["seed"] == seed and draw(seed, record["index"]).cell.name == record["cell"]:
            found[record["index"]] = record
    return list(found.values())


def trial(bench: Bench, seed: int, index: int) -> dict[str, Any]:
    """One fault on a lab; what broke the trial itself is a complaint, too.

    A computer so busy that this process stands still, or does not come to see the receiver connected in time, makes
    faults of its own: an unexpected outcome is then repeated, and it is counted how often (`late`).
    """
    fault, began = draw(seed, index), time.monotonic()
    seen, late = Seen(), 0
    for late in range(REPEATS + 1):  # noqa: B007, its last value is what counts
        with Watch() as watch:
            try:
                seen = run(bench, fault)
            except Exception as error:
                seen = Seen(complaints=[f"the trial broke: {type(error).__name__}: {error}"])
        busy = watch.longest_s > STILL_S or any(TOO_LATE in complaint for complaint in seen.complaints)
        if not seen.complaints or not busy:
            break
    return {"seed": seed, "late": late, **as_record(fault, seen, time.monotonic() - began)}


def work(seed: int, process: int, todo: Any, done: Any) -> None:
    """A process with a lab of its own, which it replaces after every unexpected outcome."""
    structlog.configure(wrapper_class=structlog.make_filtering_bound_logger(logging.CRITICAL))
    bench: Bench | None = None
    folder = Path(tempfile.mkdtemp(prefix="fault-campaign-"))
    made = 0
    while (index := todo.get()) is not None:
        if bench is None:
            made += 1
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
            bench = Bench(folder, seed=1000 * process + made)
        record = trial(bench, seed, index)
        done.put(record)
        if record["complaints"]:
            _give_up(bench)
            bench = None
    if bench is not None:
        _give_up(bench)
    shutil.rmtree(folder, ignore_errors=True)
    done.put(None)


def _give_up(bench: Bench) -> None:
    try:
        bench.end()
    except Exception as error:
        print(f"closing: {error}", flush=True)


def campaign(seed: int, wanted: Sequence[int], processes: int, journal: Path) -> None:
    """Do the faults that are not in the journal yet."""
    context = multiprocessing.get_context("spawn")
    todo, done = context.Queue(), context.Queue()
    for index in [*wanted, *[None] * processes]:
        todo.put(index)
    workers = [context.Process(target=work, args=(seed, k, todo, done), daemon=True) for k in range(processes)]
    for worker in workers:
        worker.start()
    left, bad, began = processes, 0, time.monotonic()
    with journal.open("a") as file:
        for count in range(1, len(wanted) + processes + 1):
            record = done.get()
            if record is None:
                left -= 1
                continue
            file.write(json.dumps(record) + "\n")
            file.flush()
            bad += bool(record["complaints"])
            if record["complaints"] or count % 50 == 0:
                print(f"{count}/{len(wanted)} {time.monotonic() - began:.0f} s, {bad} unexpected; {record['index']}"
                      f" {record['cell']} {record['wire']}: {record['complaints']}", flush=True)  # fmt: skip
    for worker in workers:
        worker.join(timeout=30)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--faults", type=int, default=6 * len(cells()))
    parser.add_argument("--first", type=int, default=0, help="number of the first fault")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--processes", type=int, default=4)
    parser.add_argument("--only", default="", help="only cells whose name contains this")
    parser.add_argument("--journal", type=Path, default=Path("fault-campaign.jsonl"))
    parser.add_argument("--page", type=Path)
    options = parser.parse_args()
    known = done_before(options.journal, options.seed)
    numbers = range(options.first, options.first + options.faults)
    wanted = [k for k in numbers if k not in known and options.only in draw(options.seed, k).cell.name]
    print(f"{len(wanted)} faults to do, {len(known)} known", flush=True)
    campaign(options.seed, wanted, options.processes, options.journal)
    records = last_records(options.journal, options.seed)
    if options.page:
        options.page.write_text(page.text(records, options.seed))
    bad = sum(bool(r["complaints"]) for r in records)
    print(f"{len(records)} faults, {bad} unexpected")
    raise SystemExit(1 if bad else 0)


if __name__ == "__main__":
    main()
