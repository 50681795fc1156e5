"""Undeclared effects on the simulated platform, one, two, nameless or none: are they named, and what does it cost?

Strengths are multiples of the standard deviation that the score test finds beside the declared parameters, so that
every effect is equally visible. As a program it writes docs/evidence/diagnosis-study.md:
python -m tests.campaigns.diagnosis_study
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import os
import re
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from platform_daemon.diagnosis.diagnose import diagnose_shots
from platform_daemon.diagnosis.effect_search import candidates_for
from platform_daemon.diagnosis.effects.torque import settling_candidate
from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.joint_fit import fit_jointly
from platform_daemon.diagnosis.regression.score_test import score_table
from platform_daemon.diagnosis.report import diagnosis_report
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.thread_pool import shot_pool
from platform_daemon.estimation.physics.models import model_named
from tests.campaigns.diagnosis_study_page import RATE_HZ, SAMPLE_SD, document, limits, row
from tests.kit.data import ROOT
from tests.kit.undeclared_shots import shots_with

DOCUMENT = ROOT / "docs" / "evidence" / "diagnosis-study.md"
POSES: dict[str, tuple[float, float, float] | None] = {"as mounted": None, "tilted": (0.6, -0.3, -1.1)}
TORQUES = (
    "coulomb_friction", "hertz_friction", "quadratic_drag", "angle_dependent_damping", "restoring_anharmonicity",
    "torsion_stiffness", "bias_torque",
)  # fmt: skip
RECEIVERS = ("channel_gain", "channel_delay", "receive_lowpass", "receiver_compression")
_PLAUSIBLE = 0.3  # of a gain, or of anything that would be no small effect any more
_PAIRED_FROM = 15.0  # sigma from which effects are also drawn in pairs
# What the declared parameters take up of an effect, whatever its size (the reports say so): not determined by data.
_ABSORBED = {
    "channel_gain": {"m_r_am2"},
    "crosstalk": {"rodrigues_x", "rodrigues_y", "rodrigues_z"},
    "channel_delay": {"psi_start_rad", "phi_max_rad"},
    "receive_lowpass": {"psi_start_rad", "phi_max_rad", "m_r_am2"},
    "torsion_stiffness": {"f_nat_hz"},
}


_LITTLE = re.compile(r"(\w+) gains \d+ of chi2, little beside")


@dataclass(frozen=True)
class Case:
    """One diagnosis: effect tables of the platform. nameless: they are in no list of candidates."""

    variant: str
    pose: str
    sigma: float
    effects: tuple[dict[str, Any], ...]
    seed: int
    nameless: bool = False
    uneven: bool = False  # the first effect is strong, the other one weak

    @property
    def kind(self) -> str:
        """Of the study's tables."""
        if self.nameless:
            return "nameless"
        if self.uneven:
            return "uneven"
        return ("clean", "one", "two")[len(self.effects)]


@dataclass(frozen=True)
class Outcome:
    """What came out of it.

    false: effects named although neither they nor any that they cannot be told from are there; told: effects that notes
    say are surely there, too small beside the others to be named.
    worst: parameter that lies farthest from the truth, and by how many of its standard deviations; of what the data
    determine beside the effect.
    """

    case: Case
    verdict: str
    names: tuple[str, ...]
    alike: tuple[str, ...]
    false: tuple[str, ...]
    chi2_after: float
    worst: tuple[str, float]
    seconds: float
    told: tuple[str, ...] = ()

    @property
    def right(self) -> bool:
        """Every effect named, or in the set of one that was; nothing named where there is nothing, or no name."""
        if self.case.nameless:
            return self.verdict != "explained"
        if not self.case.effects:
            return self.verdict == "nothing_missing"
        return all(e["id"] in {*self.names, *self.alike} for e in self.case.effects)

    @property
    def noted(self) -> bool:
        """What is not named, nor in the set of a name, is told in a note."""
        return all(e["id"] in {*self.names, *self.alike, *self.told} for e in self.case.effects)

    @property
    def wrong(self) -> bool:
        """A name although neither it nor any of its set is there."""
        if self.case.nameless:
            return not self.right
        return bool(self.false)

    @property
    def exact(self) -> bool:
        """Each effect by its own name and nothing else."""
        return sorted(self.names) == sorted(e["id"] for e in self.case.effects)


def visible(variant: str, pose: str, shots: int, rx_s: float | None = None) -> dict[tuple[Any, ...], float]:
    """Standard deviation of every candidate's strength beside the declared parameters."""
    clean, _ = shots_with(variant, count=shots, rx_s=rx_s, pose=POSES[pose])
    model = model_named(variant)
    with shot_pool() as pool:
        prepared, _ = initial_fits(clean, model, pool)
        base = fit_jointly(prepared, Hypothesis(model), pool)
        window_s = float(prepared[0].time_s[-1])
        seen = score_table(base, [*candidates_for(base), settling_candidate(window_s)], pool)
    found: dict[tuple[Any, ...], float] = {}
    for block in seen.blocks:
        score, c = seen.gain([block]), block.candidate
        if score is not None and c.detail.frequency_hz is None:
            scales = c.hidden if c.detail.tau_s is None else ("settling",)
            found[(c.effect.id, c.detail.axis, c.detail.start, *scales)] = float(score.sd[0])
    found["f_nat_hz", None, None] = float(np.mean([s.dynamics.w for s in base.states])) / (2.0 * math.pi)
    found["window_s", None, None] = window_s
    found["tau_s", None, None] = settling_candidate(window_s).detail.tau_s or math.nan
    return found


def effects(variant: str, sd: Mapping[tuple[Any, ...], float], sigma: float, shots: int) -> Iterator[dict[str, Any]]:
    """Effect tables of this visibility; what would have to be implausibly large is left out."""

    def size(name: str, axis: str | None = None, start_: str | None = None, *hidden: float | str) -> float:
        return sigma * sd.get((name, axis, start_, *hidden), math.inf)

    for name in TORQUES:
        if math.isfinite(size(name)):
            yield {"id": name, "strength": size(name)}
    f_nat_hz, settles = sd["f_nat_hz", None, None], size("frequency_drift", None, None, "settling")
    yield {"id": "frequency_drift", "strength": size("frequency_drift") * f_nat_hz}
    yield {"id": "frequency_drift", "strength": settles * f_nat_hz, "tau_s": sd["tau_s", None, None]}
    if variant == "jewel":
        speed = 40.0
        yield {
            "id": "stribeck_friction",
            "strength": size("stribeck_friction", None, None, speed),
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
    window_s, rate = sd["window_s", None, None], RATE_HZ
    tone = sigma * SAMPLE_SD * math.sqrt(2.0 / (window_s * rate * shots))
    yield {"id": "mains_interference", "strength": tone, "frequency_hz": 50.0, "harmonics": [1.0, 0.0, 0.5]}
    yield {"id": "spectral_line", "strength": tone, "frequency_hz": 737.3}
    decaying = 2.5 * tone * math.sqrt(2.0 * window_s / 0.3)
    yield {"id": "side_mode", "strength": decaying, "frequency_hz": 171.3, "tau_s": 0.3, "axis": "z"}
    yield {"id": "switch_transient", "strength": tone * math.sqrt(window_s / 0.01), "tau_s": 0.01, "axis": "x"}
    yield {"id": "clock_gap", "strength": max(1, round(sigma / 5.0)), "sample": int(0.4 * window_s * rate)}


def nameless(variant: str) -> Iterator[dict[str, Any]]:
    """Torques with a state of their own, at strengths that are plainly seen; the gap breathes in a band with f."""
    f_hz = {"thread": 215.7, "jewel": 213.2}[variant]
    yield {"id": "memory_relaxation", "strength": 3e-4, "tau_s": 0.02}
    yield {"id": "memory_amplitude", "strength": 1e-3, "tau_s": 0.1}
    yield {"id": "memory_bristle", "strength": 60.0, "reach_rad": 0.2}
    yield {"id": "breathing_gap", "strength": 3e-4, "frequency_hz": 2.1 * f_hz, "decay_per_s": 5.0}
    yield {"id": "second_mode", "strength": 0.01, "frequency_hz": 1.03 * f_hz, "decay_per_s": 3.0, "order": 1}
    yield {"id": "second_mode", "strength": 0.02, "frequency_hz": 2.05 * f_hz, "decay_per_s": 3.0, "order": 2}


def pairs(singles: Sequence[dict[str, Any]], count: int, rng: np.random.Generator) -> Iterator[tuple[Any, ...]]:
    """Different effects at once, drawn at random."""
    found = [(a, b) for k, a in enumerate(singles) for b in singles[k + 1 :] if a["id"] != b["id"]]
    yield from (found[int(k)] for k in rng.permutation(len(found))[:count])


def uneven(strong: Sequence[dict[str, Any]], weak: Sequence[dict[str, Any]], rng: np.random.Generator) -> Iterator[Any]:
    """Every strong effect beside a weak other one, drawn at random."""
    for effect in strong:
        others = [w for w in weak if w["id"] != effect["id"]]
        yield effect, others[int(rng.integers(len(others)))]


def cases(asked: argparse.Namespace) -> list[Case]:
    """Everything that applies; strengths are drawn at random around the multiples asked for."""
    found: list[Case] = []
    rng = np.random.default_rng(asked.seed)

    def add(variant: str, pose: str, sigma: float, *tables: dict[str, Any], **kind: bool) -> None:
        found.append(Case(variant, pose, sigma, tables, asked.seed + len(found), **kind))

    for variant in asked.variants:
        for pose in asked.poses:
            sd = visible(variant, pose, asked.shots, asked.rx_s)
            for sigma in asked.sigma:
                drawn = [dict(e, strength=_drawn(e, rng)) for e in effects(variant, sd, sigma, asked.shots)]
                for effect in drawn:
                    add(variant, pose, sigma, effect)
                for both in pairs(drawn, asked.pairs if sigma >= _PAIRED_FROM else 0, rng):
                    add(variant, pose, sigma, *both)
            if asked.uneven:
                strong, weak = (list(effects(variant, sd, s, asked.shots)) for s in asked.uneven)
                for both in uneven(strong, weak, rng):
                    add(variant, pose, asked.uneven[0], *both, uneven=True)
            for effect in nameless(variant) if asked.nameless else ():
                add(variant, pose, 0.0, effect, nameless=True)
            for _ in range(asked.clean):
                add(variant, pose, 0.0)
    return found


def _drawn(effect: dict[str, Any], rng: np.random.Generator) -> Any:
    """Its strength, more or less; samples are whole."""
    strength, factor = effect["strength"], float(rng.uniform(0.8, 1.25))
    return strength if effect["id"] == "clock_gap" else strength * factor


def run(task: tuple[Case, int, float | None]) -> Outcome:
    """One case."""
    case, shots, rx_s = task
    made, truths = shots_with(case.variant, case.effects, count=shots, rx_s=rx_s, seed=case.seed, pose=POSES[case.pose])
    report = diagnosis_report(diagnose_shots(made, model_named(case.variant))).model_dump(mode="json")
    there = {e["id"] for e in case.effects}
    return Outcome(
        case,
        report["verdict"],
        tuple(e["id"] for e in report["effects"]),
        tuple(i for e in report["effects"] for i in e["indistinguishable_from"]),
        tuple(e["id"] for e in report["effects"] if not there & {e["id"], *e["indistinguishable_from"]}),
        report["held_out"]["chi2_per_dof_after"],
        farthest(report["parameters_after"], truths, _said(report)),
        report["seconds"],
        tuple(m[1] for note in report["notes"] if (m := _LITTLE.match(note))),
    )


def _said(report: Mapping[str, Any]) -> set[str]:
    """Ids of all effects and of their look-alikes."""
    return {i for e in report["effects"] for i in (e["id"], *e["indistinguishable_from"])}


def farthest(after: Mapping[str, Any], truths: Sequence[Mapping[str, Any]], said: set[str]) -> tuple[str, float]:
    """Parameter farthest from its mean truth, in its standard deviations; without what the effects absorb."""
    skipped = set().union(*(_ABSORBED.get(i, set()) for i in said))
    found = {}
    for name, m in after.items():
        true = [t[name] for t in truths if t.get(name) is not None]
        if name in skipped or not true or not m["std"]:
            continue
        off = m["value"] - float(np.mean(true))
        if name == "psi_start_rad":
            off = math.remainder(off, 2.0 * math.pi)
        found[name] = abs(off) / m["std"]
    return max(found.items(), key=lambda item: item[1], default=("-", 0.0))


def main() -> int:
    """Run it and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--shots", type=int, default=3)
    parser.add_argument("--rx-s", type=float, help="length of a shot; else 2 s for a thread, 1.6 s for a jewel")
    parser.add_argument("--sigma", type=float, nargs="+", default=[5.0, 15.0, 50.0])
    parser.add_argument("--variants", nargs="+", default=["thread", "jewel"])
    parser.add_argument("--poses", nargs="+", default=list(POSES), choices=list(POSES))
    parser.add_argument("--clean", type=int, default=10, help="recordings without an effect, per variant and pose")
    parser.add_argument("--pairs", type=int, default=10, help="two effects at once, per variant, pose and strength")
    parser.add_argument("--uneven", type=float, nargs=2, metavar=("STRONG", "WEAK"), help="one of each, in sigma")
    parser.add_argument("--nameless", action=argparse.BooleanOptionalAction, default=True)
    parser.add_argument("--seed", type=int, default=100)
    parser.add_argument("--out", type=Path, default=DOCUMENT)
    parser.add_argument("--journal", type=Path, help="keep outcomes in this file, and go on after those it holds")
    asked = parser.parse_args()
    todo = cases(asked)
    outcomes = _finished(asked.journal, todo)
    missing = [case for case in todo if case not in [o.case for o in outcomes]]
    began, before = time.monotonic(), len(outcomes)
    cores = sorted(os.sched_getaffinity(0))
    context = multiprocessing.get_context("spawn")
    try:
        with context.Pool(len(cores)) as pool:
            for outcome in pool.imap(run, [(case, asked.shots, asked.rx_s) for case in missing]):
                outcomes.append(outcome)
                _keep(asked.journal, outcome)
                left = (time.monotonic() - began) / (len(outcomes) - before) * (len(todo) - len(outcomes))
                print(f"{len(outcomes)}/{len(todo)}, {left / 60.0:.0f} min left: {row(outcome)}", flush=True)
    except KeyboardInterrupt:
        print("stopped; the page has what is finished")
    outcomes.sort(key=lambda o: todo.index(o.case))
    text = document(outcomes, asked.shots, len(todo)) + limits(visible)
    asked.out.write_text(text, encoding="utf-8")
    return 0


def _finished(journal: Path | None, todo: Sequence[Case]) -> list[Outcome]:
    """What the journal holds of this very study, the latest of each."""
    if journal is None or not journal.exists():
        return []
    found: dict[str, dict[str, Any]] = {}
    for line in journal.read_text(encoding="utf-8").splitlines():
        held = json.loads(line)
        found[json.dumps(held["case"], sort_keys=True)] = held

    def of(case: Case, held: Mapping[str, Any]) -> Outcome:
        values: dict[str, Any] = {n: tuple(v) if isinstance(v, list) else v for n, v in held.items()}
        return Outcome(**values | {"case": case})

    return [
        of(case, held) for case in todo if (held := found.get(json.dumps(asdict(case), sort_keys=True))) is not None
    ]


def _keep(journal: Path | None, outcome: Outcome) -> None:
    if journal is not None:
        with journal.open("a", encoding="utf-8") as file:
            file.write(json.dumps(asdict(outcome)) + "\n")


if __name__ == "__main__":
    sys.exit(main())
