"""One fault under one wiring of gate and receiver: drawn by seed and number, done to the lab, and what came of it.

The host stands still, or a wire of the lab falls silent, loses bytes or answers late, for 0.05 to 2 s each, about the
TX window.  Whatever comes of the shot: power never meets the receiver, and it ends.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from sim_backend.world.world import PowerSpan
from tests.campaigns.faults.wirings import WIRINGS, Wiring
from tests.kit.emulated_lab import Lab
from tests.kit.host_process import GOOD, OFF, Host
from tests.kit.watch import Watch

CARDS, OTHERS = ("io_card_0", "io_card_1"), ("amplifier", "switch")
LEAST_S, MOST_S = 0.05, 2.0
ASKED_S = 0.4  # a shot is prepared and begun within this time of asking
SEVERAL = 4  # answers, or pieces of the samples, in a row that come late, at most
TRICKLE_S, TRICKLE = (0.01, 0.06), 200  # samples that are all late by less than anybody gives a card up for, and add up
TRIES = 20  # a computer that is too busy for lines by the host refuses clean shots by being late itself
BEGIN_S = 15.0
BREAK_S = 1e-3
BY_HAND = "restart the card's DAQ server"
IMPATIENT = (
    "limits.max_tx_duty=0.9",
    "io_card.reply_timeout_s=1.5",
    "io_card.sample_timeout_s=1.5",
    "power_amplifier.timeout_s=1.6",
    "tx_rx_switch.timeout_s=1.6",
    "lna.timeout_s=1.6",
)
STILL = "the host stands still"
SILENT = "samples come late"
HOLES = "bytes of the samples are missing"
SLOW = "answers come late"
CUT = "a link is cut"
KINDS = (STILL, SILENT, HOLES, SLOW, CUT)


@dataclass(frozen=True)
class Blow:
    """seconds: how long; for STILL at_s after the trigger, or after the shot was asked for (`early`); else `wire`, the
    fault as the lab's door takes it."""

    index: int
    wiring: Wiring
    kind: str
    seconds: float
    at_s: float = 0.0
    early: bool = False
    wire: dict[str, Any] = field(default_factory=dict)


@dataclass
class Came:
    """over_s: how much longer than its TX window power could reach the coils; still_s: how long host and lab stood
    still, on purpose or because the computer was busy; tries: of a clean shot until one was good; hand: the error says
    what a hand must do first; `complaints`: what must not be."""

    ended: str = ""
    why: str = ""
    over_s: float = 0.0
    told_s: float = 0.0
    still_s: float = 0.0
    tries: int = 0
    hand: bool = False
    complaints: list[str] = field(default_factory=list)


class Bench:
    """A lab of one wiring, and its host."""

    def __init__(self, folder: Path, wiring: Wiring, seed: int) -> None:
        self.wiring = wiring
        at = [*wiring.emulator, 'specimen="../resonators/jewel.toml"', f"seed={seed}", f"world.seed={seed}"]
        self.lab = Lab(folder, *at)
        chunk = f"io_card.chunk_samples={wiring.chunk}"
        self.host = Host(self.lab.endpoints, (*wiring.platform, chunk, *IMPATIENT))

    def end(self) -> None:
        """Host and lab end."""
        try:
            self.host.end()
        finally:
            self.lab.emulator.close()


def draw(seed: int, index: int) -> Blow:
    """Number `index` of a campaign: wirings and kinds in turn, the rest at random."""
    rng = np.random.default_rng([seed, 17, index])
    wiring = WIRINGS[index % len(WIRINGS)]
    kind = KINDS[index // len(WIRINGS) % len(KINDS)]
    seconds = float(np.exp(rng.uniform(np.log(LEAST_S), np.log(MOST_S))))
    if kind == STILL:
        early = bool(rng.random() < 0.3)
        return Blow(index, wiring, kind, seconds, float(rng.uniform(0.0, ASKED_S if early else 0.25)), early)
    if kind in (SILENT, HOLES):
        at = {"device": str(rng.choice(CARDS)), "stream": "data", "when": "shot", "after": int(rng.integers(0, 30))}
        if kind == HOLES:
            return Blow(index, wiring, kind, seconds, wire=at | {"kind": str(rng.choice(["timeout", "half_reply"]))})
        late: dict[str, Any] = {"delay_s": seconds, "count": int(rng.integers(1, SEVERAL + 1))}
        if rng.random() < 0.3:
            late = {"delay_s": float(rng.uniform(*TRICKLE_S)), "count": TRICKLE}
        return Blow(index, wiring, kind, seconds, wire=at | {"kind": "slow_link"} | late)
    at = {"device": str(rng.choice([*CARDS, *CARDS, *OTHERS])), "after": int(rng.integers(0, 12))}
    at |= {"when": str(rng.choice(["shot", "shot", "any"]))}
    if kind == SLOW:
        late = {"kind": "slow_link", "delay_s": seconds, "count": int(rng.integers(1, SEVERAL + 1))}
        return Blow(index, wiring, kind, seconds, wire=at | late)
    return Blow(
        index, wiring, kind, seconds, wire=at | {"kind": str(rng.choice(["one_way_link", "deaf_link", "disconnect"]))}
    )


def run(bench: Bench, blow: Blow) -> Came:
    """Do it, look, put it right, and ask for a clean shot.  Raises AssertionError if the host hangs."""
    world, host, came = bench.lab.emulator.world, bench.host, Came()
    violations, shots = len(world.violations()), world.shots
    began = time.monotonic()
    with Watch() as watch:
        host.ask("shot")
        striker = threading.Thread(target=_strike, args=(bench, blow, shots))
        striker.start()
        came.ended, came.why, came.still_s = host.answer()
        striker.join()
    came.told_s = time.monotonic() - began
    came.still_s += watch.total_s
    struck = range(shots + 1, world.shots + 1)
    _put_right(bench, came)
    outputs = bench.lab.control("outputs")
    if not outputs["off"] or outputs["amplifier_live"]:
        came.complaints.append(f"afterwards the outputs are not off: {outputs}")
    came.over_s = max(_longest_s([s for s in world.power_log() if s.shot in struck]) - host.gate_s, 0.0)
    if came.over_s > bench.wiring.over_s + (came.still_s if bench.wiring.follows_host else 0.0):
        came.complaints.append(f"power could reach the coils {came.over_s:.3f} s too long")
    if len(world.violations()) > violations:
        came.complaints.append(f"power met the receiver: {world.violations()[-1].cause}")
    return came


def _longest_s(spans: Sequence[PowerSpan]) -> float:
    """How long power could reach the coils without a break; the log is in pieces of at most 0.1 s."""
    longest_s, since_s, until_s = 0.0, -math.inf, -math.inf
    for span in sorted(spans, key=lambda s: s.start_s):
        since_s = since_s if span.start_s < until_s + BREAK_S else span.start_s
        until_s = span.stop_s
        longest_s = max(longest_s, until_s - since_s)
    return longest_s


def _strike(bench: Bench, blow: Blow, shots: int) -> None:
    """Now, or at its time of the shot."""
    if blow.kind != STILL:
        bench.lab.control("wire_fault", **blow.wire)
        return
    world, until = bench.lab.emulator.world, time.monotonic() + BEGIN_S
    while not blow.early and world.shots == shots and time.monotonic() < until:
        time.sleep(1e-3)
    time.sleep(blow.at_s)
    bench.host.stand_still(blow.seconds)


def _put_right(bench: Bench, came: Came) -> None:
    """Mend the wires: outputs can then be proved off, and a clean shot is good, without a hand, or the error says what
    a hand must do."""
    bench.lab.control("repair")
    tries = 0
    while (proved := _ask(bench.host, "off"))[0] != OFF and tries < TRIES:
        tries += 1
    clean = ("", "")
    while proved[0] == OFF and came.ended != GOOD and clean[0] != GOOD and came.tries < TRIES:
        came.tries += 1
        clean = _ask(bench.host, "shot")
    last = clean[1] if clean[0] else proved[1]
    if clean[0] != GOOD and BY_HAND in last:
        came.hand = True
        return
    if proved[0] != OFF:
        came.complaints.append(f"outputs cannot be proved off afterwards: {proved[1]}")
    if clean[0] not in ("", GOOD):
        came.complaints.append(f"the next clean shot is {clean[0]}: {clean[1]}")


def _ask(host: Host, what: str) -> tuple[str, str]:
    host.ask(what)
    return host.answer()[:2]


def as_record(blow: Blow, came: Came) -> dict[str, Any]:
    """Plain JSON types: a line of the campaign's journal."""
    drawn = {"index": blow.index, "wiring": blow.wiring.name, "kind": blow.kind, "seconds": blow.seconds}
    return {**drawn, "at_s": blow.at_s, "early": blow.early, "wire": blow.wire, **asdict(came)}
