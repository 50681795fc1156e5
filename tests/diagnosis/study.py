"""One undeclared effect at a time on the simulated platform: is it named, how strongly, and what does it cost?

Strengths are multiples of the standard deviation that the score test finds beside the declared parameters, so that
every effect is equally visible. As a program it writes docs/diagnosis-study.md:  python -m tests.diagnosis.study
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
import os
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from platform_daemon.diagnosis import as_json, diagnose
from platform_daemon.diagnosis.diagnose import candidates_for
from platform_daemon.diagnosis.hypothesis import Hypothesis
from platform_daemon.diagnosis.picture import picture
from platform_daemon.diagnosis.pool import shot_pool
from platform_daemon.diagnosis.refit import refit
from platform_daemon.diagnosis.start import start
from platform_daemon.estimation.models import model_named

from .simulated import shots_with

DOCUMENT = Path(__file__).parents[2] / "docs" / "diagnosis-study.md"
POSES: dict[str, tuple[float, float, float] | None] = {"as mounted": None, "tilted": (0.6, -0.3, -1.1)}
TORQUES = (
    "coulomb_friction", "hertz_friction", "quadratic_drag", "angle_dependent_damping", "restoring_anharmonicity",
    "torsion_stiffness", "bias_torque",
)  # fmt: skip
RECEIVERS = ("channel_gain", "channel_delay", "receive_lowpass", "receiver_compression")
_PLAUSIBLE = 0.3  # of a gain, or of anything that would be no small effect any more
_SD = 0.02  # A m^2/s, of a sample


@dataclass(frozen=True)
class Case:
    """One diagnosis: an effect table of the platform, or none."""

    variant: str
    pose: str
    sigma: float
    effect: dict[str, Any] | None
    seed: int


@dataclass(frozen=True)
class Outcome:
    """What came out of it."""

    case: Case
    verdict: str
    names: tuple[str, ...]
    alike: tuple[str, ...]
    chi2_after: float
    seconds: float

    @property
    def named(self) -> bool:
        """Named, or in the set of one that was."""
        if self.case.effect is None:
            return self.verdict == "nothing_missing"
        return self.case.effect["id"] in {*self.names, *self.alike}

    @property
    def wrong(self) -> bool:
        """A name although it is neither the effect nor declared alike."""
        return bool(self.names) and not self.named


def visible(variant: str, pose: str, shots: int) -> dict[tuple[Any, ...], float]:
    """Standard deviation of every candidate's strength beside the declared parameters."""
    clean, _ = shots_with(variant, count=shots, pose=POSES[pose])
    model = model_named(variant)
    with shot_pool() as pool:
        started, _ = start(clean, model, pool)
        base = refit(started, Hypothesis(model), pool)
        seen = picture(base, candidates_for(base), pool)
    found: dict[tuple[Any, ...], float] = {}
    for block in seen.blocks:
        score, c = seen.gain([block]), block.candidate
        if score is not None and c.detail.frequency_hz is None:
            found[(c.effect.id, c.detail.axis, c.detail.start, *c.hidden)] = float(score.sd[0])
    found["f_nat_hz", None, None] = float(np.mean([s.dynamics.w for s in base.states])) / (2.0 * math.pi)
    found["window_s", None, None] = float(started[0].time_s[-1])
    return found


def effects(variant: str, sd: Mapping[tuple[Any, ...], float], sigma: float, shots: int) -> Iterator[dict[str, Any]]:
    """Effect tables of this visibility; what would have to be implausibly large is left out."""

    def size(name: str, axis: str | None = None, start_: str | None = None, *hidden: float) -> float:
        return sigma * sd.get((name, axis, start_, *hidden), math.inf)

    for name in TORQUES:
        if math.isfinite(size(name)):
            yield {"id": name, "strength": size(name)}
    yield {"id": "frequency_drift", "strength": size("frequency_drift") * sd["f_nat_hz", None, None]}
    if variant == "jewel":
        speed = 40.0
        yield {
            "id": "stribeck_friction",
            "strength": size("stribeck_friction", None, None, speed) / 1190.0,
            "v_s_rad_per_s": speed,
        }
    for name in RECEIVERS:
        for axis in "xyz":
            if size(name, axis) < (_PLAUSIBLE if name in ("channel_gain", "receiver_compression") else 1e-4):
                yield {"id": name, "strength": size(name, axis), "axis": axis}
                break
    if math.isfinite(size("receive_lowpass")):
        yield {"id": "receive_lowpass", "strength": math.sqrt(size("receive_lowpass"))}
    if size("crosstalk", None, "x") < _PLAUSIBLE:
        yield {"id": "crosstalk", "strength": size("crosstalk", None, "x"), "from": "x", "to": "y"}
    window_s, rate = sd["window_s", None, None], 61035.0
    tone = sigma * _SD * math.sqrt(2.0 / (window_s * rate * shots))
    yield {"id": "mains_interference", "strength": tone, "frequency_hz": 50.0, "harmonics": [1.0, 0.0, 0.5]}
    yield {"id": "spectral_line", "strength": tone, "frequency_hz": 737.3}
    decaying = 2.5 * tone * math.sqrt(2.0 * window_s / 0.3)
    yield {"id": "side_mode", "strength": decaying, "frequency_hz": 171.3, "tau_s": 0.3, "axis": "z"}
    yield {"id": "switch_transient", "strength": tone * math.sqrt(window_s / 0.01), "tau_s": 0.01, "axis": "x"}
    yield {"id": "clock_gap", "strength": max(1, round(sigma / 5.0)), "sample": int(0.4 * window_s * rate)}


def cases(variants: Sequence[str], poses: Sequence[str], sigmas: Sequence[float], shots: int, clean: int) -> list[Case]:
    """Everything that applies."""
    found, seed = [], 100
    for variant in variants:
        for pose in poses:
            sd = visible(variant, pose, shots)
            for sigma in sigmas:
                for effect in effects(variant, sd, sigma, shots):
                    seed += 1
                    found.append(Case(variant, pose, sigma, effect, seed))
            found += [Case(variant, pose, 0.0, None, seed + 1000 + k) for k in range(clean)]
    return found


def run(task: tuple[Case, int]) -> Outcome:
    """One case."""
    case, shots = task
    undeclared = [] if case.effect is None else [case.effect]
    made, _ = shots_with(case.variant, undeclared, count=shots, seed=case.seed, pose=POSES[case.pose])
    report = as_json(diagnose(made, model_named(case.variant)))
    return Outcome(
        case,
        report["verdict"],
        tuple(e["id"] for e in report["effects"]),
        tuple(i for e in report["effects"] for i in e["indistinguishable_from"]),
        report["held_out"]["chi2_per_dof_after"],
        report["seconds"],
    )


def limits() -> str:
    """Smallest strengths found with 95 % power in 1, 10 and 100 shots, from the score test's standard deviation."""
    rows = ["", "## Detection limits", "", _LIMITS.format(sigma=_FOUND)]
    rows += ["| variant | effect | 1 shot | 10 shots | 100 shots |", "|---|---|---|---|---|"]
    for variant in ("thread", "jewel"):
        for (name, *where), sd in visible(variant, "as mounted", 1).items():
            if name in ("f_nat_hz", "window_s") or not sd < _LARGEST.get(name, math.inf):
                continue
            place = " ".join(str(w) for w in where if w is not None)
            sizes = [_FOUND * sd / math.sqrt(shots) for shots in (1, 10, 100)]
            sizes = [math.sqrt(s) for s in sizes] if (name, *where) == ("receive_lowpass", None, None) else sizes
            rows.append(f"| {variant} | {name} {place} | " + " | ".join(f"{s:.2g}" for s in sizes) + " |")
    return "\n".join(rows) + "\n"


def _row(outcome: Outcome) -> str:
    case, effect = outcome.case, outcome.case.effect
    name = "nothing" if effect is None else effect["id"] + (f" {effect['axis']}" if "axis" in effect else "")
    said = ", ".join(outcome.names) or "-"
    alike = ", ".join(outcome.alike) or "-"
    mark = "yes" if outcome.named else "**no**"
    return (
        f"| {case.variant} | {case.pose} | {name} | {case.sigma:g} | {mark} | {outcome.verdict} | {said} | {alike} "
        f"| {outcome.chi2_after:.4f} |"
    )


_FOUND = 6.0  # standard deviations: 4.35 pass the corrected level of 1e-3, and 1.65 for a power of 95 %
_LARGEST = {"channel_gain": 0.05, "channel_delay": 1e-4, "receive_lowpass": 1e-4, "crosstalk": 0.05}
_LIMITS = """Strength in the effect's unit (frequency drift relative, in 1/s; Stribeck friction in rad/s^2 at the
velocity scale named) that is found in 95 of 100 cases: {sigma:g} standard deviations of the score test beside the
declared parameters, shots as in the study.
"""
_HEAD = """# Does the diagnosis name what is missing?

Simulated recordings of {shots} shots with one effect that nobody declared to the diagnosis, made by `sim_backend`,
whose effect code is its own. Strength: multiples of the standard deviation with which the score test sees the effect
beside the declared parameters of all shots. Written by `make diagnose-study` in {minutes:.0f} minutes
(`python -m tests.diagnosis.study {options}`); do not edit.

Not applicable: effects whose strength would have to be implausible to be seen in a pose (a channel that hears nothing),
Stribeck friction without a jewel, Hertz friction beside the jewel's own.

| strength | cases | named or in its declared set | a wrong name | held-out chi2/dof after, worst |
|---|---|---|---|---|
"""
_TABLE = """
| variant | pose | effect | sigma | named | verdict | says | cannot tell it from | chi2/dof after |
|---|---|---|---|---|---|---|---|---|
"""


def document(outcomes: Sequence[Outcome], shots: int, minutes: float) -> str:
    """The study as a page."""
    lines = []
    for sigma in sorted({o.case.sigma for o in outcomes}):
        of = [o for o in outcomes if o.case.sigma == sigma]
        label = f"{sigma:g} sigma" if sigma else "nothing undeclared: nothing_missing"
        worst = max((o.chi2_after for o in of), key=lambda c: abs(c - 1.0))
        named, wrong = sum(o.named for o in of), sum(o.wrong for o in of)
        lines.append(f"| {label} | {len(of)} | {named} | {wrong} | {worst:.4f} |")
    rows = [_row(o) for o in outcomes]
    head = _HEAD.format(shots=shots, minutes=minutes, options=" ".join(sys.argv[1:]))
    return head + "\n".join(lines) + "\n" + _TABLE + "\n".join(rows) + "\n"


def main() -> int:
    """Run it and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--shots", type=int, default=3)
    parser.add_argument("--sigma", type=float, nargs="+", default=[5.0, 15.0, 50.0])
    parser.add_argument("--variants", nargs="+", default=["thread", "jewel"])
    parser.add_argument("--poses", nargs="+", default=list(POSES), choices=list(POSES))
    parser.add_argument(
        "--clean", type=int, default=10, help="recordings with nothing undeclared, per variant and pose"
    )
    parser.add_argument("--out", type=Path, default=DOCUMENT)
    asked = parser.parse_args()
    began = time.monotonic()
    todo = cases(asked.variants, asked.poses, asked.sigma, asked.shots, asked.clean)
    cores = sorted(os.sched_getaffinity(0))
    outcomes: list[Outcome] = []
    context = multiprocessing.get_context("spawn")
    with context.Pool(len(cores)) as pool:
        for outcome in pool.imap(run, [(case, asked.shots) for case in todo]):
            outcomes.append(outcome)
            left = (time.monotonic() - began) / len(outcomes) * (len(todo) - len(outcomes))
            print(f"{len(outcomes)}/{len(todo)}, {left / 60.0:.0f} min left: {_row(outcome)}", flush=True)
    text = document(outcomes, asked.shots, (time.monotonic() - began) / 60.0) + limits()
    asked.out.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
