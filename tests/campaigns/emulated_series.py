"""A series of each resonator over the emulated wires, next to the same series simulated in process.

    python -m tests.campaigns.emulated_series --page docs/evidence/emulated-series.md

Two processes per resonator, as in a lab: `platform-daemon emulate` and `platform-daemon measure`.  The worlds have the
same seed; what they would do differently by themselves, because real time passes between shots (temperature, and
friction that scatters and wears), is switched off.  Each fit is also held against the truth of its own world.
"""

from __future__ import annotations

import argparse
import json
import math
import socket
import subprocess
import tempfile
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from drivers.red_pitaya.sines import AMPLITUDE_STEP_V
from platform_daemon.core.recordings.header import FitTable
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recording import Recording
from platform_daemon.core.recordings.truth import read_truth
from tests.campaigns.standstill import LATE_S, Standstills, idle_late_s
from tests.kit.command_line import COMMAND
from tests.kit.emulator_process import STEADY, emulator
from tests.kit.fit_tables import read_fits

SETTLED_S = 0.2  # after a shot has begun its truth can be asked for
AT_START = ("phi_max_rad", "psi_start_rad")
"""Of the first shot only: later ones begin with what is left of the one before, at a phase that the pause decides; and
without a truth over wires, because the world there does not know where the sequence's RX window begins."""
DEAD_S = 0.05  # allowed between shots, beyond their windows
IDLE_S = 60.0  # for a look at the computer alone


@dataclass
class Series:
    """One series: the recording, its fits, truths by frame; from the world: (start, stop) of power, s.

    stood_still: whether the computer did between these world times, s.
    """

    recording: Recording
    fit: FitTable
    truths: list[dict[str, Any]]
    power: list[tuple[float, float]]
    violations: int = 0
    stood_still: Callable[[float, float], bool] = lambda start_s, stop_s: False


def control(endpoints: dict[str, Any], do: str, **more: Any) -> Any:
    """Ask the emulator's door into the world."""
    at = endpoints["control"]
    with socket.create_connection((at["host"], at["port"]), 10) as link, link.makefile("rwb") as stream:
        stream.write(json.dumps({"do": do, **more}).encode() + b"\n")
        stream.flush()
        answer = json.loads(stream.readline())
    if not answer["ok"]:
        raise SystemExit(answer["error"])
    return answer["result"]


def measured(out: Path, resonator: str, shots: int, *options: str) -> None:
    """`platform-daemon measure`."""
    what = ["measure", "--resonator", resonator, "--shots", str(shots), "--out", str(out), "--force", *options]
    done = subprocess.run([COMMAND, *what], capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"platform-daemon {' '.join(what)}: {done.stderr}")


def watch_truths(endpoints: dict[str, Any], truths: dict[int, dict[str, Any]], done: threading.Event) -> None:
    """Ask for the truth of each shot while it runs."""
    while not done.wait(0.05):
        shots = control(endpoints, "clock")["shots"]
        if shots and shots not in truths:
            time.sleep(SETTLED_S)
            truth = control(endpoints, "truth")
            truths[truth["shot"]] = truth


def over_wires(folder: Path, resonator: str, shots: int) -> Series:
    """The series over TCP, serial lines and USB."""
    out, truths, done = folder / f"{resonator}-wires.h5", {}, threading.Event()
    with emulator(folder, resonator) as (file, endpoints):
        watcher = threading.Thread(target=watch_truths, args=(endpoints, truths, done))
        watcher.start()
        still = Standstills()
        try:
            with still:
                measured(out, resonator, shots, "--platform", "emulated", "--endpoints", str(file))
        finally:
            done.set()
            watcher.join()
        before_s, world_s = time.monotonic(), control(endpoints, "clock")["world_s"]
        zero_s = 0.5 * (before_s + time.monotonic()) - world_s
        spans = [(s["start_s"], s["stop_s"]) for s in control(endpoints, "power_log")]
        violations = len(control(endpoints, "violations"))
    found = [truths[k + 1] for k in range(shots)]
    return Series(
        open_recording(out), fit_of(out), found, spans, violations, lambda a, b: still.during(zero_s + a, zero_s + b)
    )


def in_process(folder: Path, resonator: str, shots: int) -> Series:
    """The series in simulated time, on the grid of the cards and with their steps of the amplitude."""
    out = folder / f"{resonator}-simulated.h5"
    steady = [f"--set=backends.simulated.{table}.enabled=false" for table in STEADY]
    card = ("--set=io_card.step_samples=16", f"--set=io_card.output_step_v={AMPLITUDE_STEP_V!r}")
    measured(out, resonator, shots, *card, *steady)
    found = read_truth(out)
    assert found is not None
    return Series(open_recording(out), fit_of(out), [next(iter(t.values())) for t in found], [])


def fit_of(path: Path) -> FitTable:
    """The on-line fit of a recording."""
    return next(table for table in read_fits(path) if table.name == "d30")


def compared(name: str, wires: Series, simulated: Series) -> list[str]:
    """Rows of the table of parameters."""
    rows = []
    for k, parameter in enumerate(wires.fit.parameters):
        sigma = [np.array([math.sqrt(c[k, k]) for c in s.fit.covariance]) for s in (wires, simulated)]
        if not all(np.all(np.isfinite(s) & (s > 0)) for s in sigma):
            continue
        apart = wrapped(wires.fit.values[:, k] - simulated.fit.values[:, k], parameter) / np.hypot(*sigma)
        apart = apart[:1] if parameter in AT_START else apart
        rms, largest = math.sqrt(float(np.mean(apart**2))), float(np.max(np.abs(apart)))
        errors = [error_of(s, k, parameter) for s in (wires, simulated)]
        pulls = [f"{np.max(np.abs(e / s)):.2f}" for e, s in zip(errors, sigma, strict=True)]
        if parameter in AT_START:
            pulls[0] = "-"
        rows.append(f"| {name} | {parameter} | {rms:.2f} | {largest:.2f} | {pulls[0]} | {pulls[1]} |")
    return rows


def error_of(series: Series, k: int, parameter: str) -> np.ndarray:
    """Fit minus the truth of its own world, per shot."""
    return wrapped(series.fit.values[:, k] - np.array([t[parameter] for t in series.truths], dtype=float), parameter)


def wrapped(difference: np.ndarray, parameter: str) -> np.ndarray:
    """Phases lie on a circle."""
    return np.angle(np.exp(1j * difference)) if parameter == "psi_start_rad" else difference


def timing(name: str, wires: Series, simulated: Series) -> tuple[list[str], float]:
    """Rows on lengths, gates and the time between shots; the longest dead time, s."""
    mine, other = wires.recording.sequence, simulated.recording.sequence
    if mine != other or not all(i.valid_samples == mine.total for i in wires.recording.frame_info):
        raise SystemExit(f"{name}: windows differ: {mine} and {other}")
    rate_hz = mine.rate_hz
    gates = np.array([stop - start for start, stop in wires.power]) * rate_hz
    starts = np.array([start for start, _ in wires.power])
    window_s = mine.total / rate_hz
    dead_s = np.diff(starts) - window_s
    ran = np.array([not wires.stood_still(a + window_s, b) for a, b in pairwise(starts)])
    good = [sum(i.verdict == "good" for i in s.recording.frame_info) for s in (wires, simulated)]
    rows = [
        f"| {name} | good shots, wires and simulation | {good[0]}, {good[1]} |",
        f"| {name} | windows, samples: TX, switch, RX, the same in both | {mine.tx_samples}, {mine.switch_samples},"
        f" {mine.rx_samples} |",
        f"| {name} | power at the coils, samples, least and most | {gates.min():.6f}, {gates.max():.6f} |",
        f"| {name} | time between shots beyond their windows, ms, least, median, most | {spread(dead_s)} |",
        f"| {name} | the same, of the {ran.sum()} of {ran.size} in which that thread woke in time |"
        f" {spread(dead_s[ran]) if ran.any() else '-'} |",
        f"| {name} | power on a connected receiver, times | {wires.violations} |",
    ]
    return rows, float(dead_s.max())


def spread(times_s: np.ndarray) -> str:
    """Least, median and most in ms."""
    return ", ".join(f"{1e3 * t:.1f}" for t in (times_s.min(), float(np.median(times_s)), times_s.max()))


PAGE = """# A series over the emulated wires

{shots} shots of each resonator over two I/O cards (TCP), switch and LNA (serial) and amplifier (USBTMC), with
`platform-daemon emulate` and `platform-daemon measure` as two processes, next to the same series simulated in process
with the same seed. Written by `make emulated-series`. The cards write their sequence memory in no time here, so that
the time between shots is the daemon's; the real server takes some 100 ms more ([measured](real-card-server.md)).

Lengths and gates are read from the world's own record, the time between shots from its trigger times. A thread
of a third process sleeps meanwhile, and records when it wakes late by more than {late_ms:g} ms: then others had
the cores, or the computer stood still. For comparison: in {idle_s:g} s before all this began, with nothing of ours
running, the same thread woke late {idle_times} times, by {idle_most_ms:.1f} ms at most.

| resonator | what | value |
|---|---|---|
{timing}

Difference of the two fits of a shot over the root of the sum of their variances, rms and largest of {shots} shots, and
the largest |fit - truth| / std of either. `phi_max_rad` and `psi_start_rad` are compared in the first shot only: later
ones begin with what is left of the one before, at a phase that the real pause decides. The simulated card has the grid
of edges and the steps of amplitude (1/32767 V) that the real one has. The world behind the wires does not know where
the sequence's RX window begins, so it has no truth for them.

| resonator | parameter | rms | largest | wires, to truth | simulation, to truth |
|---|---|---|---|---|---|
{parameters}
"""


def main() -> None:
    """Command line; exit code 1 if a dead time is longer than allowed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shots", type=int, default=20)
    parser.add_argument("--resonators", nargs="+", default=["jewel", "thread"])
    parser.add_argument("--page", type=Path)
    options = parser.parse_args()
    clocks, parameters, longest, idle = [], [], 0.0, idle_late_s(IDLE_S)
    with tempfile.TemporaryDirectory(prefix="emulated-series-") as made:
        for name in options.resonators:
            folder = Path(made) / name
            folder.mkdir()
            wires, simulated = over_wires(folder, name, options.shots), in_process(folder, name, options.shots)
            rows, dead_s = timing(name, wires, simulated)
            clocks, longest = clocks + rows, max(longest, dead_s)
            parameters += compared(name, wires, simulated)
    text = PAGE.format(
        shots=options.shots,
        late_ms=1e3 * LATE_S,
        idle_s=IDLE_S,
        idle_times=len(idle),
        idle_most_ms=1e3 * max(idle, default=0.0),
        timing="\n".join(clocks),
        parameters="\n".join(parameters),
    )
    print(text)
    if options.page:
        options.page.write_text(text)
    raise SystemExit(longest > DEAD_S)


if __name__ == "__main__":
    main()
