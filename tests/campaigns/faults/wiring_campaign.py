"""Faults about the TX window, over every wiring of gate and receiver that a platform may have.

    python -m tests.campaigns.faults.wiring_campaign --blows 2000 --processes 2 --page docs/evidence/wiring-campaign.md

Seeded: number k is the same in every run.  The journal (JSON lines) lets an interrupted campaign go on.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import shutil
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tests.campaigns.faults import wiring_page
from tests.campaigns.faults.wiring_trial import Bench, Came, as_record, draw, run
from tests.campaigns.faults.wirings import WIRINGS


def work(seed: int, process: int, todo: Any, done: Any) -> None:
    """A process with a lab for each wiring it meets, which it replaces after every complaint."""
    folder = Path(tempfile.mkdtemp(prefix="wiring-campaign-"))
    benches: dict[str, Bench] = {}
    made = 0
    while (index := todo.get()) is not None:
        blow = draw(seed, index)
        name = blow.wiring.name
        try:
            if name not in benches:
                made += 1
                (at := folder / str(made)).mkdir()
                benches[name] = Bench(at, blow.wiring, seed=1000 * process + made)
            came = run(benches[name], blow)
        except Exception as error:
            came = Came(complaints=[f"the trial broke: {type(error).__name__}: {error}"])
        done.put({"seed": seed, **as_record(blow, came)})
        if (came.complaints or came.hand) and name in benches:
            benches.pop(name).end()
    for bench in benches.values():
        bench.end()
    shutil.rmtree(folder, ignore_errors=True)
    done.put(None)


def campaign(seed: int, wanted: Sequence[int], processes: int, journal: Path) -> None:
    """Do the blows of these numbers; whatever is not as it must be is printed."""
    context = multiprocessing.get_context("spawn")
    todo, done = context.Queue(), context.Queue()
    for index in [*wanted, *[None] * processes]:
        todo.put(index)
    workers = [context.Process(target=work, args=(seed, k, todo, done)) for k in range(processes)]
    for worker in workers:
        worker.start()
    left, bad, count, began = processes, 0, 0, time.monotonic()
    with journal.open("a") as file:
        while left:
            record = done.get()
            if record is None:
                left -= 1
                continue
            file.write(json.dumps(record) + "\n")
            file.flush()
            count, bad = count + 1, bad + bool(record["complaints"])
            if record["complaints"] or count % 50 == 0:
                print(
                    f"{count}/{len(wanted)} {time.monotonic() - began:.0f} s, {bad} not as it must be; "
                    f"{record['index']} {record['wiring']}: {record['kind']}: {record['complaints']}",
                    flush=True,
                )
    for worker in workers:
        worker.join()


def done_before(journal: Path, seed: int) -> dict[int, dict[str, Any]]:
    """The last record of every number of this seed."""
    lines = journal.read_text().splitlines() if journal.exists() else []
    return {r["index"]: r for r in map(json.loads, lines) if r["seed"] == seed}


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--blows", type=int, default=400 * len(WIRINGS))
    parser.add_argument("--first", type=int, default=0, help="number of the first one")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--journal", type=Path, default=Path("wiring-campaign.jsonl"))
    parser.add_argument("--page", type=Path)
    options = parser.parse_args()
    known = {k for k, r in done_before(options.journal, options.seed).items() if not r["complaints"]}
    wanted = [k for k in range(options.first, options.first + options.blows) if k not in known]
    print(f"{len(wanted)} to do, {len(known)} known", flush=True)
    campaign(options.seed, wanted, options.processes, options.journal)
    records = list(done_before(options.journal, options.seed).values())
    if options.page:
        options.page.write_text(wiring_page.text(records, options.seed))
    bad = sum(bool(r["complaints"]) for r in records)
    print(f"{len(records)} blows, {bad} not as they must be")
    raise SystemExit(1 if bad else 0)


if __name__ == "__main__":
    main()
