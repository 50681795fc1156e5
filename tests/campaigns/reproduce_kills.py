"""`platform-daemon reproduce`, killed in each of its parts and resumed, against a campaign that nobody killed.

python -m tests.campaigns.reproduce_kills --shots 3 [--page FILE]

The command is killed (SIGKILL, with all its processes) while it measures the thread, fits the jewel, adds noise, and
writes the report.  In the end each recording must have every shot once, what was whole at a death must be there bit by
bit, and the thread's claims must be those of a campaign left alone.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.features.characterise.side_by_side.sweep import PARTS
from platform_daemon.features.reproduce.campaign import BLANK_SHOTS, outcome_in
from platform_daemon.features.reproduce.schema import Claim, Claims
from tests.kit.command_line import COMMAND
from tests.kit.data import ROOT

_LOOK_S = 0.05
_PART = "part-*.json"
_LONGEST_S = 3600.0
HEAD = """# The paper's campaign, killed and resumed

`make reproduce-kills` (`python -m tests.campaigns.reproduce_kills --shots {shots}`): `platform-daemon
reproduce` with {shots} shots of `thread_published` and of `jewel_published`, without tune and ramps.
The command with all its processes is killed (SIGKILL) in four phases, one after the other, and
continued by `--resume` each time. Whole are the recordings with their reports and the parts of the
noise sweep; each must be there bit by bit after every later death and at the end. Each recording has
every shot once. The claims of the thread's fits, but for times of computing, must be those of a
campaign that nobody killed, digit by digit.

| | |
|---|---|
"""


def _measures(variant: str) -> Callable[[Path], bool]:
    return lambda folder: any((folder / f".{variant}.h5.shots").glob("*"))


def _fits(variant: str) -> Callable[[Path], bool]:
    return lambda folder: (folder / f"{variant}.h5").is_file() and outcome_in(folder, variant) is None


PHASES: dict[str, Callable[[Path], bool]] = {
    "measuring the thread": _measures("thread"),
    "fits of the jewel": _fits("jewel"),
    "noise": lambda folder: any((folder / PARTS).glob(_PART)),
    "report": lambda folder: (folder / "noise.json").is_file(),
}
"""Where it is killed, and how that is seen in its folder."""


@dataclass
class Found:
    """What the deaths have left.

    Attributes:
        kept: files that were whole at each death, by its phase.
        claims: of the thread's fits that were compared with a campaign left alone.
        wrong: in words.
    """

    kept: dict[str, int] = field(default_factory=dict)
    claims: int = 0
    wrong: list[str] = field(default_factory=list)


def reproduce_kills(place: Path, shots: int) -> Found:
    """What was kept and what is wrong.  Raises AssertionError: a phase is not met, or a campaign does not end well."""
    found, folder, alone = Found(), place / "killed", place / "alone"
    resume: list[str] = []
    kept: dict[Path, str] = {}
    for phase, reached in PHASES.items():
        _killed(_words(folder, shots, *resume), phase, partial(reached, folder))
        resume = ["--resume"]
        found.wrong += changed(kept)
        whole = [folder / f"{v}.h5" for v in ("thread", "jewel") if outcome_in(folder, v) is not None]
        kept |= {path: digest(path) for path in (*whole, *(folder / PARTS).glob(_PART))}
        found.kept[phase] = len(kept)
        print(f"killed in {phase}: {len(kept)} files are whole", flush=True)
    assert not (folder / "claims.json").exists()
    _run(_words(folder, shots, *resume))
    found.wrong += changed(kept)
    for variant in ("thread", "jewel"):
        frames = open_recording(folder / f"{variant}.h5").frames - BLANK_SHOTS
        if frames != shots:
            found.wrong.append(f"{variant}: {frames} shots, not {shots}")
    _run(_words(alone, shots, jewel="none"))
    ours, theirs = _thread_claims(folder), _thread_claims(alone)
    found.claims = len(ours)
    found.wrong += [f"{a.what}: {a.ours}, alone {b.ours}" for a, b in zip(ours, theirs, strict=True) if a != b]
    return found


def changed(kept: Mapping[Path, str]) -> list[str]:
    """Files whose digest is no longer that which was kept of them, in words."""
    return [f"{path.name} has changed" for path, before in kept.items() if digest(path) != before]


def _words(folder: Path, shots: int, *more: str, jewel: str = "jewel_published") -> list[str]:
    """Of a campaign without tune and ramps."""
    words = ["--out", str(folder), "--shots", str(shots), "--no-tune", "--no-ramp", "--thread", "thread_published"]
    return [str(COMMAND), "reproduce", *words, "--jewel", jewel, *more]


def _killed(words: list[str], phase: str, reached: Callable[[], bool]) -> None:
    with subprocess.Popen(words, start_new_session=True, stdout=subprocess.DEVNULL) as program:
        end_s = time.monotonic() + _LONGEST_S
        while not reached():
            assert program.poll() is None, f"it ended before it was killed in {phase}"
            assert time.monotonic() < end_s, phase
            time.sleep(_LOOK_S)
        os.killpg(program.pid, signal.SIGKILL)


def _run(words: list[str]) -> None:
    done = subprocess.run(words, capture_output=True, text=True, timeout=_LONGEST_S, check=False)
    assert done.returncode == 0, done.stderr


def digest(path: Path) -> str:
    """Of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _thread_claims(folder: Path) -> list[Claim]:
    """Of the thread's fits, but for times of computing."""
    found = Claims.model_validate_json((folder / "claims.json").read_bytes())
    return [c for c in found.claims if c.what.startswith("thread ") and "time of a fit" not in c.what]


def page(found: Found, shots: int) -> str:
    """The page."""
    rows = [(f"killed: {phase}", f"{kept} files were whole, and stayed") for phase, kept in found.kept.items()]
    rows += [
        ("claims of the thread's fits, compared with a campaign left alone", str(found.claims)),
        ("wrong", "; ".join(found.wrong) or "nothing"),
    ]
    return HEAD.format(shots=shots) + "".join(f"| {what} | {value} |\n" for what, value in rows)


def main() -> int:
    """See the module; exit code 1 if anything is wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shots", type=int, default=3, help="of each resonator")
    parser.add_argument("--page", type=Path)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        found = reproduce_kills(Path(place), asked.shots)
    text = page(found, asked.shots)
    print(text)
    if asked.page is not None:
        (ROOT / asked.page).write_text(text)
    return int(bool(found.wrong))


if __name__ == "__main__":
    sys.exit(main())
