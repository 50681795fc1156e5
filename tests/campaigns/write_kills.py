"""Kills inside the write path: at every call that touches the disk, before and after it, and at random moments.

python -m tests.campaigns.write_kills --kills 1000 --page docs/evidence/write-kills.md

A process writes series of four shots and the records of a job; each is acknowledged when the writer says so.  It is
killed (SIGKILL), the folder is opened as at a start of the daemon, and what is there is counted.  In a second part the
start itself, which assembles series and imports the files of jobs of an earlier version, is killed at every call, and
made again.
"""

from __future__ import annotations

import argparse
import itertools
import json
import logging
import multiprocessing
import os
import random
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from platform_daemon.core.recordings.data_folder import open_data_folder
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.series_writer import SeriesWriter
from platform_daemon.core.state.database import Database
from platform_daemon.core.state.durable import write_file
from platform_daemon.core.state.logs import log_from
from platform_daemon.core.state.state_file import STATE, STATE_SCHEMA, UPSERT_JOB
from tests.kit.recording_files import header, shot, volts
from tests.kit.stored_jobs import job_texts

SHOTS = 4
EARLIER = 3
"""Jobs of an earlier version, each in a file."""
CALLS = ("open", "fsync", "replace", "rename", "link", "mkdir", "unlink", "rmdir", "write", "close", "posix_fallocate")
HEAD = """# Kills in the write path

`make write-kills` (`python -m tests.campaigns.write_kills {arguments}`). A process writes series of {shots} shots and
the record of a job, and is killed with SIGKILL: at every call that touches the disk, before and after it, then at
random moments; so is the start that assembles what it left and imports jobs of an earlier version. Then the folder is
opened as at a start of the daemon. Lost: a shot or a record of a job that was acknowledged, and is not there as it was.
Doubled: there twice. Junk: neither recording nor record.

| killed | kills | shots acknowledged | lost | doubled | junk |
|---|---|---|---|---|---|
"""


@dataclass
class Found:
    """What was counted after some kills."""

    kills: int = 0
    acknowledged: int = 0
    lost: int = 0
    doubled: int = 0
    junk: list[str] = field(default_factory=list)

    def row(self, name: str) -> str:
        """Of the page."""
        return f"| {name} | {self.kills} | {self.acknowledged} | {self.lost} | {self.doubled} | {len(self.junk)} |"

    @property
    def clean(self) -> bool:
        """Nothing is lost, doubled or left."""
        return not (self.lost or self.doubled or self.junk)


class Trap:
    """Kills this process at the call of that number, from 0; counts them all.  number None: never."""

    def __init__(self, number: int | None, *, after: bool) -> None:
        self.calls, self._number, self._after = 0, number, after
        for name in CALLS:
            setattr(os, name, self._watched(getattr(os, name)))

    def _watched(self, call: Callable[..., object]) -> Callable[..., object]:
        def watched(*arguments: object, **named: object) -> object:
            mine, self.calls = self.calls, self.calls + 1
            if mine == self._number and not self._after:
                os.kill(os.getpid(), signal.SIGKILL)
            try:
                return call(*arguments, **named)
            finally:
                if mine == self._number:
                    os.kill(os.getpid(), signal.SIGKILL)

        return watched


def write(folder: Path, told: Connection, number: int | None, *, after: bool, ever: bool) -> None:
    """Series after series if `ever`, else one; shots are acknowledged as (series, shot), records as [job, shot]."""
    trap = Trap(number, after=after)
    state = Database(folder / STATE, STATE_SCHEMA)
    for series in itertools.count() if ever else (0,):
        with SeriesWriter.create(folder / f"recordings/s{series}.h5", header(planned_shots=SHOTS)) as writer:
            for k in range(1, SHOTS + 1):
                writer.add_shot(shot(k))
                told.send((series, k))
                state.execute(UPSERT_JOB, (f"s{series}", "running", f'{{"shots": {k}}}'))
                told.send([f"s{series}", k])
            writer.finish()
    told.send(trap.calls)


def start(folder: Path, told: Connection, number: int | None, *, after: bool) -> None:
    """As the daemon does."""
    trap = Trap(number, after=after)
    open_data_folder(folder)
    told.send(trap.calls)


def run(
    work: Callable[..., None], *arguments: object, kill_after_s: float | None = None, **named: object
) -> list[object]:
    """What a process has said until it was killed or has ended."""
    context = multiprocessing.get_context("fork")
    ours, theirs = context.Pipe(duplex=False)
    folder, *rest = arguments
    process = context.Process(target=work, args=(folder, theirs, *rest), kwargs=named)
    process.start()
    theirs.close()
    said = []
    if kill_after_s is not None:
        said.append(ours.recv())
        time.sleep(kill_after_s)
        process.kill()
    try:
        while True:
            said.append(ours.recv())
    except EOFError:
        process.join()
    return said


def look(folder: Path, said: list[object], found: Found) -> None:
    """Open the folder as at a start, and count."""
    open_data_folder(folder).lock.close()  # type: ignore[union-attr]
    acknowledged = {each for each in said if isinstance(each, tuple)}
    jobs = {name: json.loads(text)["shots"] for name, text in job_texts(folder).items()}
    records: dict[str, int] = {}
    for name, shots in (each for each in said if isinstance(each, list)):
        records[name] = shots
    found.lost += sum(jobs.get(name, -1) < shots for name, shots in records.items())
    seen: Counter[tuple[int, int]] = Counter()
    for path in (folder / "recordings").glob("*.h5"):
        recording, series = open_recording(path), int(path.name.split(".")[0][1:])
        for k, info in enumerate(recording.frame_info):
            if np.array_equal(recording.frame_volts(k), volts(info.shot)):
                seen[series, info.shot] += 1
    found.kills += 1
    found.acknowledged += len(acknowledged)
    found.lost += len(acknowledged - seen.keys())
    found.doubled += sum(count > 1 for count in seen.values())
    found.junk += [
        p.name for p in (folder / "recordings").iterdir() if p.suffix != ".h5" and not p.name.startswith(".index.db")
    ]
    found.junk += [p.name for p in folder.iterdir() if p.suffix == ".part" or p.name.startswith("jobs")]


def fresh(parent: Path) -> Path:
    """An empty data folder."""
    folder = Path(tempfile.mkdtemp(dir=parent))
    open_data_folder(folder).lock.close()  # type: ignore[union-attr]
    Database(folder / STATE, STATE_SCHEMA).close()
    return folder


def at_every_call(parent: Path) -> Found:
    """The writer is killed before and after every call."""
    found = Found()
    calls = int(str(run(write, fresh(parent), None, after=False, ever=False)[-1]))
    for number, after in itertools.product(range(calls), (False, True)):
        folder = fresh(parent)
        look(folder, run(write, folder, number, after=after, ever=False), found)
    return found


def at_every_call_of_a_start(parent: Path) -> Found:
    """A writer is killed after three shots, then the start that finds them, before and after every call."""
    found, number, after = Found(), 0, False
    while True:
        folder = fresh(parent)
        said = run(write, folder, _after_three(parent), after=True, ever=False)
        (folder / "jobs").mkdir()
        for k in range(EARLIER):
            write_file(folder / f"jobs/earlier{k}.json", b'{"shots": 0, "state": "done"}')
            said.append([f"earlier{k}", 0])
        ended = run(start, folder, number, after=after)
        look(folder, said, found)
        if ended:  # it came to its end: there are no further calls
            return found
        number, after = (number, True) if not after else (number + 1, False)


_THREE: dict[Path, int] = {}


def _after_three(parent: Path) -> int:
    """Number of the call after which three shots of four are acknowledged and the fourth is not."""
    if parent not in _THREE:
        calls = int(str(run(write, fresh(parent), None, after=False, ever=False)[-1]))
        _THREE[parent] = next(n for n in range(calls) if _shots_before(parent, n) == SHOTS - 1)
    return _THREE[parent]


def _shots_before(parent: Path, number: int) -> int:
    """How many shots are acknowledged when the writer is killed after the call of that number."""
    return sum(isinstance(each, tuple) for each in run(write, fresh(parent), number, after=True, ever=False))


def at_random(parent: Path, kills: int, seed: int) -> Found:
    """The writer is killed at a random moment of many series."""
    found, draw = Found(), random.Random(seed)
    for _ in range(kills):
        folder = fresh(parent)
        wait_s = draw.uniform(0.0, 0.2)
        look(folder, run(write, folder, None, after=False, ever=True, kill_after_s=wait_s), found)
    return found


def main() -> int:
    """All kinds of kills; exit code 1 if anything was lost, doubled or left."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=1000, help="in all, at least; those beyond every call are random")
    parser.add_argument("--seed", type=int, default=1, help="of the random moments")
    parser.add_argument("--page", type=Path, help="write it, as docs/evidence/write-kills.md")
    asked = parser.parse_args()
    rows, every = [], []
    log_from(logging.ERROR)
    with tempfile.TemporaryDirectory() as folder:
        parent = Path(folder)
        for name, kinds in (
            ("writer, at every call", at_every_call),
            ("start, at every call", at_every_call_of_a_start),
        ):
            every.append(kinds(parent))
            rows.append(every[-1].row(name))
            print(rows[-1], flush=True)
        left = max(0, asked.kills - sum(each.kills for each in every))
        every.append(at_random(parent, left, asked.seed))
        rows.append(every[-1].row("writer, at random moments"))
        print(rows[-1], flush=True)
    for each in every:
        if each.junk:
            print(sorted(set(each.junk))[:20], file=sys.stderr)
    if asked.page is not None:
        arguments = f"--kills {asked.kills} --page docs/evidence/write-kills.md"
        asked.page.write_text(HEAD.format(arguments=arguments, shots=SHOTS) + "\n".join(rows) + "\n", encoding="utf-8")
    return int(not all(each.clean for each in every))


if __name__ == "__main__":
    sys.exit(main())
