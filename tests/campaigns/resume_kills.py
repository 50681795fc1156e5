"""A series that is cut off again and again, resumed each time, against the same series left alone.

python -m tests.campaigns.resume_kills --kills 200 --page docs/evidence/resume-kills.md

A daemon on the simulated platform measures series; the process that owns the hardware is killed (SIGKILL) at random
moments, and the series is resumed by REST once it is back, until it is whole.  Each recording must have every shot
once, in order, and mark where it was joined; the shots that were acknowledged before a death must be there after it,
bit by bit.  Fits of resumed series are held against those of series that nobody cut off, in units of their errors.
What the world does differently by itself between shots (temperature, scatter of friction, wear) is switched off.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recording import Recording
from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.data import ROOT
from tests.kit.emulator_process import STEADY
from tests.kit.fit_tables import read_fits
from tests.kit.served import Served, served

SHOTS, ALONE = 300, 2
"""Of a series; series that nobody cuts off."""
LIVES_S = (10.5, 14.0), (0.5, 4.0), (0.5, 4.0), (0.5, 4.0)
"""Between which times after it was there again the process dies, in turn: one that dies within 10 s of its start waits
before the next one, longer each time."""
COMPARED = ("f_nat_hz", "lambda_per_s", "tf_over_i_rad_per_s2")
MOST = 5.0
"""Standard errors that a fit may be off: of some 10 000 the largest is about 4."""
SPREAD = 0.05
"""... and how much their spread may differ from 1."""
_CUTS = 4  # of one series
_BACK_S = 60.0
_SERIES_S = 600.0  # a whole series, beside other programs
HEAD = """# Series that were killed and resumed

`make resume-kills` (`python -m tests.campaigns.resume_kills {arguments}`): series of {shots} shots (jewel, RX 0.6 s,
fits in N50) on the simulated platform; the process that owns the hardware is killed (SIGKILL) at random moments, and
the series is resumed by `POST /acquisitions/ID/resume` once it is back. Fits are held against {alone} series of the
same kind that were not interrupted: (value - their mean) / standard deviation, for {compared}.

| | |
|---|---|
"""


@dataclass
class Found:
    """What came of it."""

    kills: int = 0
    in_a_series: int = 0
    """Kills that met a series before it had ended."""
    series: int = 0
    shots: int = 0
    wrong: list[str] = field(default_factory=list)
    off: list[float] = field(default_factory=list)
    """Of every fit and parameter, in standard errors."""
    back_s: list[float] = field(default_factory=list)
    """From a death until the platform answers again."""


@dataclass(frozen=True)
class Plan:
    """What is done: deaths in all, shots of a series, how long a process lives."""

    kills: int
    shots: int = SHOTS
    lives_s: tuple[tuple[float, float], ...] = LIVES_S


def resume_kills(folder: Path, plan: Plan, seed: int = 1) -> Found:
    """Raises AssertionError if something does not come back."""
    found, chance, data = Found(), random.Random(seed), folder / "data"
    steady = [word for table in STEADY for word in ("--set", f"backends.simulated.{table}.enabled=false")]
    with served(data, *steady) as daemon:
        lone = [_whole(daemon, plan, 0, chance, found) for _ in range(ALONE)]
        means = {name: np.mean([_values(each, name)[0] for each in lone]) for name in COMPARED}
        found.series = found.shots = 0
        while found.kills < plan.kills:
            path = _whole(daemon, plan, min(_CUTS, plan.kills - found.kills), chance, found)
            for name in COMPARED:
                values, errors = _values(path, name)
                found.off += list((values - means[name]) / errors)
    return found


def _begun(daemon: Served, shots: int) -> str:
    request = {**SHORT_JEWEL, "shots": shots, "window": "n50"}
    return str(_until(lambda: _accepted(daemon.post("/acquisitions", request)))["id"])


def _whole(daemon: Served, plan: Plan, cuts: int, chance: random.Random, found: Found) -> Path:
    """The recording of a series once it is whole, after some deaths."""
    job = _begun(daemon, plan.shots)
    path, before = Path(daemon.folder) / f"recordings/{job}.h5", list[NDArray[np.float64]]()
    joins = set[int]()  # after which shots; two deaths with none in between are one
    for _ in range(cuts):
        time.sleep(chance.uniform(*plan.lives_s[found.kills % len(plan.lives_s)]))
        pid = daemon.pid("hardware")
        if pid is None:
            continue
        told = _shots(daemon, job)
        os.kill(pid, signal.SIGKILL)
        found.kills += 1
        begun_s = time.monotonic()
        _until(lambda: daemon.get("/platform").status_code == 200)
        found.back_s.append(time.monotonic() - begun_s)
        state = _until(lambda: _ended(daemon, job))
        if state == "done":
            break
        found.in_a_series += 1
        kept = open_recording(path) if path.exists() else None
        frames = 0 if kept is None else kept.frames
        if frames < told:
            found.wrong.append(f"{job}: {told} shots were told, {frames} are there")
        before += [] if kept is None else [kept.frame_volts(k) for k in range(len(before), frames)]
        joins |= {frames} - {0, plan.shots}
        _until(lambda: _accepted(daemon.post(f"/acquisitions/{job}/resume", {})))
    state = _until(lambda: _ended(daemon, job), _SERIES_S)
    if state != "done":
        found.wrong.append(f"{job} has ended as {state}: {daemon.get(f'/acquisitions/{job}').json()['error']}")
    whole = open_recording(path)
    found.wrong += [*_complaints(job, whole, plan.shots, joins), *_changed(job, before, whole)]
    found.series, found.shots = found.series + 1, found.shots + whole.frames
    return path


def _changed(job: str, before: list[NDArray[np.float64]], whole: Recording) -> list[str]:
    same = all(np.array_equal(whole.frame_volts(k), volts) for k, volts in enumerate(before))
    return [] if same else [f"{job}: a shot of before is another one"]


def _complaints(job: str, whole: Recording, shots: int, joins: set[int]) -> list[str]:
    numbers, out = [info.shot for info in whole.frame_info], []
    if numbers != list(range(1, shots + 1)):
        out.append(f"{job}: its shots are {numbers}")
    marked = {info.shot - 1 for info in whole.frame_info if info.joined}
    if marked != joins:
        out.append(f"{job}: joined after shots {sorted(marked)}, cut off after {sorted(joins)}")
    if whole.provenance.incomplete is not None:
        out.append(f"{job}: {whole.provenance.incomplete}")
    return out


def _values(path: Path, name: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Values and standard deviations of a parameter, of good fits."""
    (fit,) = read_fits(path)
    column, good = list(fit.parameters).index(name), np.array(fit.verdict) == "good"
    return fit.values[good, column], fit.std[good, column]


def _shots(daemon: Served, job: str) -> int:
    """That count by now; 0 while nobody can say."""
    answer = daemon.get(f"/acquisitions/{job}")
    return int(answer.json()["result"].get("shots") or 0) if answer.status_code == 200 else 0


def _accepted(answer: Any) -> Any:
    return answer.json() if answer.status_code == 202 else None


def _ended(daemon: Served, job: str) -> str | None:
    answer = daemon.get(f"/acquisitions/{job}")
    state = answer.json()["state"] if answer.status_code == 200 else "running"
    return state if state in ("done", "failed", "cancelled") else None


def _until(there: Callable[[], Any], patience_s: float = _BACK_S) -> Any:
    """What it gives once it gives something.  Raises AssertionError if that takes longer."""
    until = time.monotonic() + patience_s
    while not (found := there()):
        assert time.monotonic() < until, "it does not come back"
        time.sleep(0.05)
    return found


def complaints(found: Found) -> list[str]:
    """What must not be."""
    out, off = list(found.wrong), np.array(found.off)
    if np.abs(off).max() > MOST:
        out.append(f"a fit is {np.abs(off).max():.1f} standard errors off")
    if abs(off.std() - 1.0) > SPREAD:
        out.append(f"the fits spread by {off.std():.2f} of their errors")
    return out


def page(found: Found, arguments: str) -> str:
    """The page."""
    off, wrong = np.array(found.off), complaints(found)
    rows = [
        ("deaths", f"{found.kills}, {found.in_a_series} of them in a series"),
        ("series that were made whole", f"{found.series}, {found.shots} shots"),
        ("shots lost, doubled or changed; joins not marked", str(len(found.wrong))),
        ("fits and parameters compared", str(off.size)),
        (
            "mean, spread and largest, in standard errors",
            f"{off.mean():+.3f}, {off.std():.3f}, {np.abs(off).max():.1f}",
        ),
        ("platform answers again", f"{np.median(found.back_s):.1f} s (median), {max(found.back_s):.1f} s at most"),
        ("wrong", "; ".join(wrong[:5]) or "nothing"),
    ]
    head = HEAD.format(arguments=arguments, shots=SHOTS, alone=ALONE, compared=", ".join(COMPARED))
    return head + "".join(f"| {what} | {value} |\n" for what, value in rows)


def main() -> int:
    """See the module; exit code 1 if anything is wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--page", type=Path)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        found = resume_kills(Path(folder), Plan(asked.kills))
    text = page(found, f"--kills {asked.kills}")
    print(text)
    if asked.page is not None:
        (ROOT / asked.page).write_text(text)
    return int(bool(complaints(found)))


if __name__ == "__main__":
    sys.exit(main())
