"""Series that a script measures by the client, beside a daemon that is killed and started again.

python -m tests.campaigns.client_kills --shots 10000 --page docs/evidence/client-kills.md

The script is what a user would write: it starts a series, waits for its end, and resumes it where the daemon has died.
Meanwhile, at random moments, a process of the daemon or all of them together are killed (SIGKILL), and a new daemon is
started on the same folder and port.  In the end there must be one acquisition for each that the script has started, and
in its recording every shot once.  With --folder a campaign that was interrupted itself goes on: each series has an
idempotency key, so that those there are already are not measured again.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

import httpx2
import psutil

from platform_daemon.client import Client, Conflict, ConnectionFailed, JobFailed, Unavailable
from platform_daemon.core.schemas.jobs import JobState
from tests.kit.command_line import COMMAND
from tests.kit.served import Served

SERIES = 50
"""Shots of a series."""
APART = (5, 1500)
"""Least and largest number of shots between two deaths."""
_VICTIMS = ("all", "hardware", "web")
_WATCHED = ("script", "daemon", "hardware", "web")
_ROW = 1000  # shots in a row of the table of memory
_BACK_S = 900.0  # on a computer that does much else, a start of all processes takes minutes
_TRIES = 50  # to bring one series to its end
HEAD = """# Series of a script beside a daemon that is killed

`make client-kills` (`python -m tests.campaigns.client_kills {arguments}`): a script measures series of {series} shots
(jewel, RX 0.2 s, no fits) on the simulated platform by `platform_daemon.client`, and resumes those that were cut off.
Meanwhile all processes of the daemon together, its hardware process or its web process are killed (SIGKILL) in turn;
after all of them, a new daemon is started on the same folder and port.

| | |
|---|---|
"""
MEMORY_HEAD = f"""
Largest resident memory after a series, in MB; the processes of the daemon begin anew with each death:

| shots | {" | ".join(_WATCHED)} |
|---|{"---|" * len(_WATCHED)}"""


@dataclass
class Found:
    """What came of it."""

    series: int = 0
    shots: int = 0
    kills: dict[str, int] = field(default_factory=lambda: dict.fromkeys(_VICTIMS, 0))
    resumed: int = 0
    before: int = 0
    """Series that were there already."""
    wrong: list[str] = field(default_factory=list)
    memory_mb: list[dict[str, float]] = field(default_factory=list)
    """Resident memory after each series, by process; one that is just dead or being started is left out."""
    seconds: float = 0.0


class Lives:
    """A daemon on one port that is started again after each death."""

    def __init__(self, folder: Path) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.folder, self.log = folder / "data", folder / "log"
        self.address = f"http://127.0.0.1:{self.port}"
        self._daemon: Served
        self.start()

    def start(self) -> None:
        """A new daemon; returns when it listens.  What was killed may hold the port until its processes have ended."""
        command = [str(COMMAND), "serve", "--port", str(self.port), "--data", str(self.folder)]
        until_s = time.monotonic() + _BACK_S
        while True:
            with self.log.open("a") as log:
                process = subprocess.Popen(
                    command, stdout=subprocess.PIPE, stderr=log, text=True, start_new_session=True
                )
            assert process.stdout is not None
            if process.stdout.readline():
                break
            process.communicate()
            assert time.monotonic() < until_s, self.log.read_text()[-1000:]
            time.sleep(0.2)
        self._daemon = Served(process, self.address, "", self.folder)

    def kill(self, victim: str) -> None:
        """Kill that process, or all of them; the daemon is there again on return."""
        if victim == "all":
            os.killpg(self._daemon.process.pid, signal.SIGKILL)
            self._daemon.process.communicate()
            self._daemon.close()
            self.start()
        elif self._daemon.pid(victim) is not None:
            with suppress(ProcessLookupError):
                self._daemon.kill(victim)

    def memory_mb(self) -> dict[str, float]:
        """Resident memory of the script and of the processes of the daemon that are there."""
        pids, found = {"script": os.getpid(), "daemon": self._daemon.process.pid}, {}
        with suppress(OSError):  # the daemon is just dead
            pids |= {name: pid for name in ("hardware", "web") if (pid := self._daemon.pid(name)) is not None}
        for name, pid in pids.items():
            with suppress(psutil.Error):
                found[name] = psutil.Process(pid).memory_info().rss / 1e6
        return found

    def wait_for_shots(self, count: int, done: threading.Event) -> bool:
        """Wait until so many shots were made in this life, however busy the machine is; True if `done` comes first."""
        seen, made = ("", 0.0), -1.0  # newest series and its shots; shots in this life, -1: it has not answered yet
        while not done.wait(0.1):
            if self._daemon.process.poll() is not None:  # it did not bring a process back in its time, and has ended
                self._daemon.close()
                self.start()
            with suppress(httpx2.TransportError, LookupError):
                newest = self._daemon.get("/jobs?limit=1&kind=acquisition").json()["items"][0]
                now = newest["id"], newest["progress"]["done"]
                if made >= 0:
                    made += now[1] - (seen[1] if now[0] == seen[0] else seen[1] - SERIES)
                seen, made = now, max(made, 0.0)
                if made >= count:
                    return False
        return True

    def close(self) -> None:
        """End the daemon as a user would."""
        self._daemon.process.send_signal(signal.SIGTERM)
        self._daemon.process.communicate(timeout=_BACK_S)
        self._daemon.close()


@contextmanager
def struck(lives: Lives, found: Found, apart: tuple[int, int], seed: int) -> Iterator[None]:
    """A thread kills the daemon again and again until the block has ended."""
    done, chance = threading.Event(), random.Random(seed)

    def strike() -> None:
        while not lives.wait_for_shots(chance.randint(*apart), done):
            victim = _VICTIMS[sum(found.kills.values()) % len(_VICTIMS)]
            lives.kill(victim)
            found.kills[victim] += 1

    thread = threading.Thread(target=strike)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def client_kills(folder: Path, shots: int, apart: tuple[int, int] = APART, seed: int = 1) -> Found:
    """Measure so many shots, and count what is there."""
    found, began = Found(), time.monotonic()
    lives = Lives(folder)
    try:
        with Client(lives.address) as lab:
            found.before = len([job for job in lab.jobs_of("acquisition") if job.state is JobState.DONE])
            started: list[str] = []
            with struck(lives, found, apart, seed):
                while len(started) * SERIES < shots:
                    started.append(_measured(lab, len(started), found))
                    found.memory_mb.append(lives.memory_mb())
                    _tell(found)
            _count(lab, started, found)
    finally:
        lives.close()
    found.seconds = time.monotonic() - began
    return found


def _tell(found: Found) -> None:
    """One line, so that the log of a campaign that is ended from outside says how far it came."""
    memory = ", ".join(f"{name} {value:.1f}" for name, value in found.memory_mb[-1].items())
    print(f"series {len(found.memory_mb)}, deaths {found.kills}, resumed {found.resumed}, MB: {memory}", flush=True)


def _measured(lab: Client, number: int, found: Found) -> str:
    """One series, brought to its end; its id."""
    options = {"rx_s": 0.2, "window": None, "comment": f"series {number}"}
    job = None
    while job is None:  # a daemon that takes longer than the client's patience to come back
        with suppress(ConnectionFailed, Unavailable):
            job = lab.measure("jewel", shots=SERIES, idempotency_key=f"series {number}", **options)
    for _ in range(_TRIES):
        try:
            job.wait()
            return job.id
        except (ConnectionFailed, Unavailable):
            continue
        except JobFailed:
            with suppress(ConnectionFailed, Unavailable, Conflict):
                job.resume()
                found.resumed += 1
    found.wrong.append(f"{job.id} was not brought to its end: {job.view.error}")
    return job.id


def _count(lab: Client, started: list[str], found: Found) -> None:
    """Is each series there once, and each shot of it?"""
    there = [job.id for job in lab.jobs_of("acquisition")]
    if sorted(there) != sorted(started):
        found.wrong.append(f"{len(started)} series were started, {len(there)} are there")
    for identifier in started:
        numbers = [frame.shot for frame in lab.recordings[identifier].info().shots]
        found.series, found.shots = found.series + 1, found.shots + len(numbers)
        if numbers != list(range(1, SERIES + 1)):
            found.wrong.append(f"{identifier} has the shots {numbers}")


def page(found: Found, arguments: str) -> str:
    """The page of evidence."""
    killed = ", ".join(f"{name} {count}" for name, count in found.kills.items())
    rows = {
        "series, shots": f"{found.series}, {found.shots}",
        **({"series of an earlier run, which was interrupted": str(found.before)} if found.before else {}),
        "deaths": f"{sum(found.kills.values())} ({killed})",
        "series that were resumed": str(found.resumed),
        "duration": f"{found.seconds:.0f} s",
        "shots or series lost, made twice or out of order": "; ".join(found.wrong) or "none",
    }
    lines = "\n".join(f"| {name} | {value} |" for name, value in rows.items())
    return HEAD.format(arguments=arguments, series=SERIES) + lines + "\n" + _memory_table(found)


def _memory_table(found: Found) -> str:
    """The largest resident memory of each process while each thousand of shots was measured."""
    lines = [MEMORY_HEAD]
    each = _ROW // SERIES
    for first in range(0, len(found.memory_mb), each):
        rows = found.memory_mb[first : first + each]
        largest = [max((row[name] for row in rows if name in row), default=None) for name in _WATCHED]
        words = " | ".join("-" if value is None else f"{value:.1f}" for value in largest)
        lines.append(f"| {(first + len(rows)) * SERIES} | {words} |")
    return "\n".join(lines) + "\n"


def main() -> int:
    """By hand."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shots", type=int, default=10_000)
    parser.add_argument("--page", type=Path)
    parser.add_argument("--folder", type=Path, help="keep everything here, and go on with what is there")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="client-kills-") as temporary:
        folder = options.folder or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        found = client_kills(folder, options.shots)
    text = page(found, f"--shots {options.shots}")
    print(text)
    if options.page is not None:
        options.page.write_text(text)
    return 1 if found.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
