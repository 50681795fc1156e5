"""`platform-daemon reproduce`, killed in each of its parts and resumed, against a campaign that nobody killed.

python -m tests.campaigns.reproduce_kills --shots 2

The command is killed (SIGKILL, with all its processes) while it measures the thread, the jewel, and while it adds
noise.  In the end each recording must have every shot once, what was whole at a death must be there bit by bit, the
same folder must give the same claims again, and the thread's claims must be those of a campaign left alone.
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
from collections.abc import Callable
from functools import partial
from pathlib import Path

from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.features.characterise.side_by_side.sweep import PARTS
from platform_daemon.features.reproduce.command import outcome_in
from platform_daemon.features.reproduce.schema import Claim, Claims
from tests.kit.command_line import COMMAND

_LOOK_S = 0.05
_PART = "part-*.json"
_LONGEST_S = 3600.0


def _measures(variant: str) -> Callable[[Path], bool]:
    return lambda folder: (folder / f"{variant}.h5").is_file() and outcome_in(folder, variant) is None


def _adds_noise(folder: Path) -> bool:
    return any((folder / PARTS).glob(_PART))


PHASES: dict[str, Callable[[Path], bool]] = {
    "thread": _measures("thread"),
    "jewel": _measures("jewel"),
    "noise": _adds_noise,
}
"""Where it is killed, and how that is seen in its folder."""


def reproduce_kills(place: Path, shots: int) -> list[str]:
    """What is wrong.  Raises AssertionError if a phase is not met, or a campaign does not end well."""
    wrong, folder, alone = list[str](), place / "killed", place / "alone"
    resume: list[str] = []
    kept: dict[Path, str] = {}
    for phase, reached in PHASES.items():
        _killed(_words(folder, shots, *resume), phase, partial(reached, folder))
        resume = ["--resume"]
        whole = [folder / f"{v}.h5" for v in ("thread", "jewel") if outcome_in(folder, v) is not None]
        kept |= {path: _digest(path) for path in (*whole, *(folder / PARTS).glob(_PART))}
        print(f"killed in {phase}: {len(kept)} files are whole", flush=True)
    _run(_words(folder, shots, *resume))
    wrong += [f"{path.name} has changed" for path, digest in kept.items() if _digest(path) != digest]
    for variant in ("thread", "jewel"):
        frames = open_recording(folder / f"{variant}.h5").frames
        if frames != shots:
            wrong.append(f"{variant}: {frames} shots, not {shots}")
    first = (folder / "claims.json").read_bytes()
    _run(_words(folder, shots, *resume))
    if (folder / "claims.json").read_bytes() != first:
        wrong.append("the same folder gives other claims")
    _run([*_words(alone, shots), "--jewel", "none"])
    ours, theirs = _thread_claims(folder), _thread_claims(alone)
    wrong += [f"{a.what}: {a.ours}, alone {b.ours}" for a, b in zip(ours, theirs, strict=True) if a != b]
    return wrong


def _words(folder: Path, shots: int, *more: str) -> list[str]:
    """Of a campaign without tune and ramps."""
    words = ["--out", str(folder), "--shots", str(shots), "--no-tune", "--no-ramp", "--thread", "thread_published"]
    return [str(COMMAND), "reproduce", *words, "--jewel", "jewel_published", *more]


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


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _thread_claims(folder: Path) -> list[Claim]:
    """Of the thread's fits, but for times of computing."""
    found = Claims.model_validate_json((folder / "claims.json").read_bytes())
    return [c for c in found.claims if c.what.startswith("thread ") and "time of a fit" not in c.what]


def main() -> None:
    """Kill, resume, and say what is wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--shots", type=int, default=2, help="of each resonator")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        wrong = reproduce_kills(Path(place), asked.shots)
    print("\n".join(wrong) or "nothing was lost, nothing was measured twice, and the claims are the same")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
