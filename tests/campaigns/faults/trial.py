"""One fault: drawn from the catalogue by seed and number, done to the lab, and what came of it."""

from __future__ import annotations

import re
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from drivers.errors import DeviceError, PlatformError
from platform_daemon.core.jobs.jobs import Job
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.schemas.jobs import JobState
from tests.campaigns.faults.bench import Bench
from tests.campaigns.faults.catalogue import DEAD, SLOW, Cell, Outcome, cells

OFF_WITHIN_S = 0.1  # stated: the sample-timed gate closes by itself, whatever has happened to the host or the wire
SHORT_REPLY, RECORD = 3, 21  # bytes: `1\r\n`, and the status record after each chunk
SLOWEST_S = 0.2
SHOTS = 2


@dataclass(frozen=True)
class Fault:
    """What to do: a cell, the shot it strikes (1 or 2), and the numbers of a wire fault.

    write: of the data stream, (chunk, 0: its samples or 1: its record), None: it strikes commands.
    """

    index: int
    cell: Cell
    shot: int = 1
    wire: dict[str, Any] = field(default_factory=dict)
    write: tuple[int, int] | None = None

    @property
    def outcome(self) -> Outcome:
        """What is expected."""
        return self.cell.expected.of_shot(last=self.shot == SHOTS)


@dataclass
class Seen:
    """What came of it; `complaints` is empty if it is what was expected and nothing unsafe happened.

    off_s: from the fault until power could no longer reach the coils; told_s: until the job or the start had ended.
    """

    outcome: str = ""
    text: str = ""
    off_s: float = 0.0
    told_s: float = 0.0
    complaints: list[str] = field(default_factory=list)


def draw(seed: int, index: int) -> Fault:
    """Fault number `index` of a campaign: the cells in turn, their numbers at random."""
    catalogue = cells()
    cell, rng = catalogue[index % len(catalogue)], np.random.default_rng([seed, index])
    site, first_only = cell.site, cell.site.early or cell.site.phase in ("self-test", "idle")
    shot = 1 if first_only else int(rng.integers(1, SHOTS + 1))
    if cell.world:
        return Fault(index, cell, shot)
    wire = {"kind": cell.kind, "device": cell.device, "when": site.when}
    if cell.kind == SLOW:
        wire["delay_s"] = float(rng.uniform(0.05, SLOWEST_S))
    if cell.kind == "disconnect":
        wire["at_byte"] = int(rng.integers(0, RECORD if site.chunks else SHORT_REPLY))
    if not site.chunks:
        return Fault(index, cell, shot, {**wire, "command": str(rng.choice(site.commands))})
    record = 1 if cell.kind == "garbage" else int(rng.integers(2))
    return Fault(index, cell, shot, {**wire, "stream": "data"}, (int(rng.choice(site.chunks)), record))


def run(bench: Bench, fault: Fault) -> Seen:
    """Do it, look, and put everything right again.  Raises AssertionError if the daemon hangs."""
    seen, violations = Seen(), len(bench.world.violations())
    bench.start()
    began = time.monotonic()
    if fault.cell.site.early:
        _start_under_fault(bench, fault, seen)
    else:
        _series_under_fault(bench, fault, seen)
    seen.told_s = time.monotonic() - began
    _judge(fault, seen)
    _look_at_outputs(bench, fault, seen)
    _put_right(bench, fault, seen)
    if len(bench.world.violations()) > violations:
        seen.complaints.append(f"power met the receiver: {bench.world.violations()[-1].cause}")
    return seen


def _start_under_fault(bench: Bench, fault: Fault, seen: Seen) -> None:
    bench.close()
    struck = _arm(bench, fault)
    try:
        bench.start()
    except PlatformError as error:
        seen.outcome, seen.text = Outcome.NO_START, f"{type(error).__name__}: {error}"
    if not struck():
        seen.complaints.append("the fault did not strike")
    if bench.engine is not None:
        shots = bench.world.shots
        job, target = bench.series(SHOTS)
        _read_series(bench, job, target, shots, seen)
    seen.off_s = _power_after(bench, struck()) if seen.outcome == Outcome.NO_START else 0.0


def _series_under_fault(bench: Bench, fault: Fault, seen: Seen) -> None:
    tested = fault.cell.site.phase == "self-test"
    shots, strikes = bench.world.shots, []
    engine = bench.start()

    def arm() -> None:
        strikes.append(_arm(bench, fault, struck_shot=shots + fault.shot))

    def before() -> None:
        if fault.shot == 1:
            arm()
        if fault.cell.site.phase == "idle":
            engine._hardware.refresh()

    def before_shot(number: int) -> None:
        if number == fault.shot:
            arm()

    job, target = bench.series(SHOTS, self_test=tested, before=before, before_shot=before_shot)
    struck = strikes[0]() if strikes else []
    if not struck:
        seen.complaints.append("the fault did not strike")
    _read_series(bench, job, target, shots, seen)
    if tested and job.error is not None and not target.exists():
        seen.outcome = Outcome.SELF_TEST
    if seen.outcome in (Outcome.SHOT_REFUSED, Outcome.SELF_TEST):  # others may come after it
        seen.off_s = _power_after(bench, struck, shots + fault.shot)
    elif seen.outcome != Outcome.VALID:
        seen.off_s = _power_after(bench, struck)


def _arm(bench: Bench, fault: Fault, struck_shot: int = 0) -> Any:
    """Let the fault come; returns what tells the world times at which it has struck."""
    if fault.cell.world:
        bench.world.faults.inject(fault.cell.kind, struck_shot)
        return lambda: [s.start_s for s in bench.shots[struck_shot - 1 : struck_shot]]
    if fault.cell.site.phase == "reconnect":
        bench.lab.control("wire_fault", kind="disconnect", device=fault.cell.device, stream="data", after=7)
    after = {}
    if fault.write is not None:
        chunk, record = fault.write
        after = {"after": 2 * (chunk % bench.chunks()) + record}
    bench.lab.control("wire_fault", **fault.wire, **after)
    wire = bench.lab.emulator.faults[fault.cell.device]
    return lambda: list(wire.strikes)


def _read_series(bench: Bench, job: Job, target: Path, shots: int, seen: Seen) -> None:
    """Outcome of a series, and whether what was acknowledged is there and right; shots: played before it."""
    triggered = bench.world.shots - shots
    stored = job.result.shots or 0
    frames = open_recording(target).frame_info if target.exists() else ()
    refused = [f.reason for f in frames if f.verdict != "good"]
    if len(frames) != stored:
        seen.complaints.append(f"{stored} shots were acknowledged, {len(frames)} are in the file")
    failed = job.error is not None and triggered > stored  # a shot that was begun and not stored
    if frames:
        seen.complaints += bench.wrong_samples(target, bench.world.shots - stored - failed)
    if job.state is JobState.DONE:
        seen.outcome = Outcome.SHOT_REFUSED if refused else Outcome.VALID
        seen.text = "; ".join(refused)
        if len(frames) != SHOTS or len(refused) > 1:
            seen.complaints.append(f"{len(frames)} shots, {len(refused)} of them refused: {refused}")
        return
    seen.text = f"{type(job.error).__name__}: {job.error}"
    seen.outcome = Outcome.STOPPED if triggered > stored else Outcome.BEFORE_POWER


def _power_after(bench: Bench, struck: list[float], shot: int | None = None) -> float:
    """How long after the last strike power could still reach the coils, s; `shot`: in that shot only."""
    at_s = struck[-1] if struck else 0.0
    spans = [p for p in bench.world.power_log() if shot in (None, p.shot)]
    return max([p.stop_s - at_s for p in spans], default=0.0) if spans else 0.0


def _judge(fault: Fault, seen: Seen) -> None:
    wanted = fault.cell.expected
    if seen.outcome != fault.outcome:
        seen.complaints.append(f"expected: {fault.outcome}; seen: {seen.outcome} {seen.text[:300]}")
    elif not re.search(wanted.words, seen.text):
        seen.complaints.append(f"expected {wanted.words!r} in {seen.text[:300]!r}")
    if seen.off_s > OFF_WITHIN_S:
        seen.complaints.append(f"power could reach the coils for {seen.off_s:.3f} s after the fault")


def _look_at_outputs(bench: Bench, fault: Fault, seen: Seen) -> None:
    """Everything off by the world's own record; an amplifier whose link is dead may stay enabled behind its gate."""
    outputs = bench.lab.control("outputs")
    deaf_amplifier = fault.cell.kind in DEAD and fault.cell.device == "amplifier"
    if not outputs["off"] or (outputs["amplifier_live"] and not deaf_amplifier):
        seen.complaints.append(f"afterwards the outputs are not off: {outputs}")


def _put_right(bench: Bench, fault: Fault, seen: Seen) -> None:
    """Mend the lab, let the operator prove outputs off, and ask for a clean shot, after a device's fault with a
    self-test."""
    bench.lab.control("repair")
    engine = bench.start()
    if not engine._hardware.alive:
        seen.complaints.append("the daemon's hardware thread is dead")
    if bench.world.power.fault is not None:
        engine.platform.amplifier.reset_fault()
    try:
        engine.outputs_off()
    except DeviceError as error:
        seen.complaints.append(f"after the repair outputs cannot be proved off: {error}")
        return
    job, target = bench.series(1, self_test=fault.cell.world)
    frames = open_recording(target).frame_info if target.exists() else ()
    seen.complaints += bench.wrong_samples(target, bench.world.shots - 1) if frames else []
    if job.state is not JobState.DONE or [f.verdict for f in frames] != ["good"]:
        reasons = [f.reason for f in frames]
        seen.complaints.append(f"the next clean shot is not good: {job.state} {job.error} {reasons}")


def as_record(fault: Fault, seen: Seen, seconds: float) -> dict[str, Any]:
    """Plain JSON types: a line of the campaign's journal."""
    cell = fault.cell
    what = {"index": fault.index, "cell": cell.name, "shot": fault.shot, "wire": fault.wire}
    return {**what, **asdict(seen), "expected": fault.outcome, "seconds": round(seconds, 2)}
