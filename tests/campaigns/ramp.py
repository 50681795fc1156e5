"""Ramps by the hundred on the simulated world: the threshold found beside the world's own, overshoot, false stops.

python -m tests.campaigns.ramp --page docs/evidence/ramp-study.md --journal ramps.jsonl
python -m tests.campaigns.ramp --only "thread, as shipped" --ramps 10

Every shot is what the world's rotor does from rest at that field, found once every 2 uT, and noise that the world makes
anew for each shot: that of the paper's receivers, or a multiple.  With scatter every shot is one of its own: friction,
contact, orientation, temperature vary as the world has them, and the threshold beside is that without.  Detector,
sequential test and escalation are those of the program; engine and calibration are left out.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from platform_daemon.features.ramp.escalation import Escalation, RampPlan
from platform_daemon.features.ramp.schema import RampRequest
from platform_daemon.features.ramp.z_residual import ZNoise, z_residual
from sim_backend.world.side_motion import VISIBLE_AM2_PER_S
from tests.kit.side_modes import changed
from tests.kit.simulated_bench import CLOCK, QUIET, Bench

GRID_UT = 2  # the finest step of a ramp
LEARN = 3  # blank shots
RX_S = {"thread": 1.0, "jewel": 0.5}  # the thread's side modes have grown by then, the jewel's come with the kick
SHIPPED = {"thread": (150, 340), "jewel": (480, 700)}


@dataclass(frozen=True)
class Case:
    """So many ramps on one rotor between two fields, uT; tilt, degrees, and T_f/I as shipped if None."""

    name: str
    specimen: str
    span_ut: tuple[int, int]
    noise: float = 1.0
    tilt_deg: float | None = None
    friction: float | None = None
    ramps: int = 100
    scatter: bool = False

    @property
    def rx_s(self) -> float:
        """Long enough for the side modes of this variant."""
        return RX_S[self.specimen.partition("_")[0]]


CASES = (
    Case("thread, as shipped", "thread_imperfect", SHIPPED["thread"]),
    Case("thread, 3 times the noise", "thread_imperfect", SHIPPED["thread"], 3.0),
    Case("thread, tilt 0.6 deg", "thread_imperfect", SHIPPED["thread"], tilt_deg=0.6, ramps=20),
    Case("thread, tilt 1.5 deg", "thread_imperfect", (80, 300), tilt_deg=1.5, ramps=20),
    Case("jewel, as shipped", "jewel_imperfect", SHIPPED["jewel"]),
    Case("jewel, 3 times the noise", "jewel_imperfect", SHIPPED["jewel"], 3.0),
    Case("jewel, scatter from shot to shot", "jewel_imperfect", SHIPPED["jewel"], scatter=True),
    Case("thread, scatter from shot to shot", "thread_imperfect", SHIPPED["thread"], ramps=20, scatter=True),
    Case("jewel, half the friction", "jewel_imperfect", (300, 700), friction=600.0, ramps=20),
    Case("thread without side modes", "thread", (100, 300), ramps=500),
    Case("thread without side modes, 3 times the noise", "thread", (100, 300), 3.0, ramps=500),
    Case("thread without side modes, 10 times the noise", "thread", (100, 300), 10.0, ramps=500),
)


@dataclass(frozen=True)
class Outcome:
    """One ramp; fields in uT. above: of its shots above the true threshold."""

    case: str
    seed: int
    threshold: tuple[float, float, float] | None
    highest: float
    shots: int
    above: int
    stopped: bool


class Rotor:
    """The world's dm/dt (3, n) and z residual at a field, found when first asked for."""

    def __init__(self, case: Case) -> None:
        self._bench = Bench(None, **QUIET)
        self._bench.backend.mount(changed(case.specimen, case.tilt_deg, None, case.friction))
        self._rx_s = case.rx_s
        self._seen: dict[int, tuple[NDArray[np.float32], float]] = {}

    def at(self, field_t: float) -> tuple[NDArray[np.float32], float]:
        """Both, at the nearest field of the grid."""
        field_ut = GRID_UT * round(1e6 * field_t / GRID_UT)
        if field_ut not in self._seen:
            self._bench.backend.world.hold_still()
            dmdt = dipole(self._bench, 1e-6 * field_ut, self._rx_s)
            size = self._bench.truth().get("z_residual_am2_per_s") or 0.0
            self._seen[field_ut] = dmdt.astype(np.float32), size
        return self._seen[field_ut]

    def threshold_ut(self, span_ut: tuple[int, int]) -> float | None:
        """Where the true z residual first passes what is visible, on a line between two fields of the grid."""
        below = 0.0
        for field_ut in range(span_ut[0], span_ut[1] + 1, GRID_UT):
            size = self.at(1e-6 * field_ut)[1]
            if size > VISIBLE_AM2_PER_S:
                return field_ut - GRID_UT * (size - VISIBLE_AM2_PER_S) / (size - below)
            below = size
        return None


def dipole(bench: Bench, field_t: float, rx_s: float) -> NDArray[np.float64]:
    """dm/dt (3, n) of a shot, as an exact calibration makes it."""
    samples = int(rx_s * CLOCK.rate_hz)
    volts = bench.shot(field_t, rx=samples, chunk=samples)
    setup, _ = bench.backend.world.shot_simulator.result()
    found: NDArray[np.float64] = (
        -np.linalg.inv(setup.lna_gain * setup.sensitivity_t_per_a) @ (volts[:, setup.timeline.rx_start :])
    )
    return found


def ramp(case: Case, rotor: Rotor, seed: int) -> Outcome:
    """One ramp to its end."""
    receivers = Bench(None, noise__scale=case.noise, seed=seed + 1)
    varied = Bench(case.specimen, noise__scale=case.noise, seed=seed + 1) if case.scatter else None

    def shot(field_t: float) -> NDArray[np.float64]:
        if varied is not None:
            varied.backend.world.hold_still()
            return dipole(varied, field_t, case.rx_s)
        return rotor.at(field_t)[0] + dipole(receivers, 0.0, case.rx_s)

    asked = RampRequest(kind="ramp", acquisition={"resonator": case.specimen})  # type: ignore[arg-type]
    low, high = (1e-6 * f for f in case.span_ut)
    plan = RampPlan(low, asked.step_t, high, asked.overdose_rate, asked.false_stop_rate, asked.most_shots)
    noise = ZNoise.of([dipole(receivers, 0.0, case.rx_s) for _ in range(LEARN)], CLOCK.rate_hz)
    state, fields = Escalation(plan), []
    while (field_t := state.next_field()) is not None:
        fields.append(field_t)
        state.see(field_t, [z_residual(shot(field_t), noise)])
    found = state.threshold_t()
    threshold = None if found is None else (1e6 * found[0], 1e6 * found[1], 1e6 * found[2])
    true_ut = rotor.threshold_ut(case.span_ut)
    above = 0 if true_ut is None else sum(1e6 * f > true_ut for f in fields)
    stopped = "no side modes" not in state.why_ended()
    return Outcome(case.name, seed, threshold, 1e6 * max(fields), LEARN + len(fields), above, stopped)


def told(case: Case, true_ut: float | None, ramps: Sequence[Outcome]) -> str:
    """A row of the page."""
    if true_ut is None:
        stops = sum(one.stopped for one in ramps)
        shots = np.mean([one.shots for one in ramps])
        return f"| {case.name} | none | {len(ramps)} | {stops} stopped | - | - | - | {shots:.1f} |"
    values = np.array([one.threshold[0] for one in ramps if one.threshold is not None])
    inside = sum(one.threshold is not None and one.threshold[1] <= true_ut <= one.threshold[2] for one in ramps)
    spread = (
        "-"
        if not len(values)
        else (f"{values.mean():.1f} ± {values.std():.1f} ({values.min():.1f} to {values.max():.1f})")
    )
    row = (
        case.name,
        f"{true_ut:.1f}",
        f"{len(values)} of {len(ramps)}",
        spread,
        str(inside),
        f"{max(one.highest for one in ramps) - true_ut:+.1f}",
        f"{sum(one.above > 0 for one in ramps)} of {len(ramps)}",
        f"{np.mean([one.shots for one in ramps]):.1f}; ladder {2 + int((true_ut - case.span_ut[0]) // 10)}",
    )
    return f"| {' | '.join(row)} |"


HEAD = """# Ramps by the hundred

Written by `python -m tests.campaigns.ramp --page docs/evidence/ramp-study.md`; do not edit. Every ramp has noise of
its own; how the shots are made, and what is left out, is in the first lines of `tests/campaigns/ramp.py`. Fields in µT.
*True*: where the world's own z residual first passes 0.4 A m²/s. *Inside*: ramps whose 95 % interval holds the true
threshold. *Above by*: the highest field of any ramp less the true threshold; *above in*: ramps with a shot above it.
*Ladder*: shots of the paper's plain steps of 10 µT, one shot each, up to the first above the true threshold.

| rotor | true | found in | threshold: mean ± standard deviation (range) | inside | above by | above in | shots |
| --- | --- | --- | --- | --- | --- | --- | --- |
"""


def _finished(journal: Path | None) -> list[Outcome]:
    if journal is None or not journal.exists():
        return []
    rows = [json.loads(line) for line in journal.read_text("utf-8").splitlines()]
    return [Outcome(**{**row, "threshold": row["threshold"] and tuple(row["threshold"])}) for row in rows]


def _missing(case: Case, rotor: Rotor, done: Sequence[Outcome], ramps: int) -> Iterator[Outcome]:
    have = {one.seed for one in done}
    for seed in range(ramps):
        if seed not in have:
            yield ramp(case, rotor, seed)


def main() -> int:
    """Run what the journal does not hold, then write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", help="the case of this name")
    parser.add_argument("--ramps", type=int, help="of every case; else 20, 100 or 500; 0: none but the journal's")
    parser.add_argument("--journal", type=Path, help="finished ramps, which are not run again")
    parser.add_argument("--page", type=Path, help="write it, as docs/evidence/ramp-study.md")
    asked = parser.parse_args()
    cases = [case for case in CASES if asked.only in (None, case.name)]
    if not cases:
        parser.error(f"no case {asked.only!r}; there are: {'; '.join(case.name for case in CASES)}")
    kept, rows = _finished(asked.journal), []
    for case in cases:
        rotor, began = Rotor(case), time.monotonic()
        ramps = [one for one in kept if one.case == case.name]
        for one in _missing(case, rotor, ramps, case.ramps if asked.ramps is None else asked.ramps):
            ramps.append(one)
            if asked.journal is not None:
                with asked.journal.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(asdict(one)) + "\n")
        if not ramps:
            rows.append(f"| {case.name} | not run | - | - | - | - | - | - |")
            continue
        rows.append(told(case, rotor.threshold_ut(case.span_ut), ramps))
        print(rows[-1], f"{time.monotonic() - began:.0f} s", flush=True)
    if asked.page is not None:
        asked.page.write_text(HEAD + "\n".join(rows) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
