"""The diagnosis on jewels and threads with drawn effects that make N50 and D30 disagree, as the paper's do.

Are the effects named, and do the two windows agree afterwards?  A jewel has a friction or a frequency that fluctuates,
a thread a frequency that settles or a dry friction; beside it there may be a channel that reads too little. Nobody
tells the diagnosis. As a program it prints a row for each resonator, then the shares:
python -m tests.campaigns.paper_loop --variant jewel --count 20 --seed 1
"""

from __future__ import annotations

import argparse
import math
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from platform_daemon.diagnosis.diagnose import diagnose_shots
from platform_daemon.diagnosis.report import diagnosis_report
from platform_daemon.diagnosis.report_schema import DiagnosisReport
from platform_daemon.estimation.physics.models import model_named
from tests.kit.undeclared_shots import shots_with

_RX_S = {"jewel": 2.0, "thread": 8.0}
_AGREES_SIGMA = 3.29  # the paper's significance of 0.001
_COMPARED = ("f_nat_hz", "m_r_am2", "lambda_per_s", "tf_over_i_rad_per_s2")
_WITHIN = 3.0  # stated errors


@dataclass(frozen=True)
class Row:
    """One resonator: its effects, the report, and its true parameters (means over the shots)."""

    effects: tuple[dict[str, Any], ...]
    report: DiagnosisReport
    truth: dict[str, float]
    seconds: float

    @property
    def named(self) -> bool:
        """Every effect has its name, or is among the look-alikes of one."""
        sets = [{e.id, *e.indistinguishable_from} for e in self.report.effects]
        return all(any(each["id"] in found for found in sets) for each in self.effects)

    @property
    def false(self) -> bool:
        """An effect is named of which nothing in its set is there."""
        ids = {each["id"] for each in self.effects}
        return any(not ids & {e.id, *e.indistinguishable_from} for e in self.report.effects)

    @property
    def agrees(self) -> bool:
        """No parameter of N50 differs significantly afterwards."""
        after = [d.after_sigma for name, d in self.report.n50_d30.items() if name in _COMPARED]
        return bool(after) and all(x is not None and x < _AGREES_SIGMA for x in after)

    @property
    def farthest(self) -> tuple[float, str]:
        """How many of its stated errors the worst parameter is off, and its name."""
        found = self.report.parameters_after
        pairs = [(name, found[name], value) for name, value in self.truth.items() if name in found]
        off = [(abs(m.value - value) / m.std, name) for name, m, value in pairs if m.value is not None and m.std]
        return max(off, default=(math.nan, ""))

    def text(self) -> str:
        """One line."""
        effects = " + ".join(f"{w['id']} {w['strength']:.3g}" for w in self.effects)
        names = " + ".join(
            f"{e.id} {e.strength.value or math.nan:.3g}({e.strength.std or math.nan:.2g})" for e in self.report.effects
        )
        off, name = self.farthest
        marks = f"named {self.named:d} false {self.false:d} agrees {self.agrees:d} farthest {off:.1f} {name}"
        return f"{effects} | {self.report.verdict}: {names or '-'} | {marks} | {self.seconds:.0f} s"


def drawn_effects(variant: str, rng: np.random.Generator) -> tuple[dict[str, Any], ...]:
    """Of one resonator."""
    found: list[dict[str, Any]] = []
    if variant == "jewel":
        share, tau_s = math.exp(rng.uniform(math.log(0.05), math.log(0.3))), math.exp(rng.uniform(-3.0, -1.2))
        # Of 5 to 30 %, or of 0.05 to 0.3 Hz.
        what = "friction_fluctuation" if rng.uniform() < 0.5 else "frequency_fluctuation"
        found.append({"id": what, "strength": share, "tau_s": tau_s})
    elif rng.uniform() < 0.5:
        rate = math.copysign(rng.uniform(0.05, 0.3), rng.uniform(-1.0, 1.0))
        found.append({"id": "frequency_drift", "strength": rate, "tau_s": rng.uniform(0.2, 0.8)})
    else:
        found.append({"id": "coulomb_friction", "strength": rng.uniform(5.0, 30.0)})
    if rng.uniform() < 0.7:
        gain = -rng.uniform(0.01, 0.06)
        found.append({"id": "channel_gain", "strength": gain, "axis": "y"})
    return tuple(found)


def diagnosed_resonator(variant: str, seed: int, shots: int) -> Row:
    """A resonator with drawn effects, and what the diagnosis says of its shots."""
    effects = drawn_effects(variant, np.random.default_rng([11, seed]))
    data, truths = shots_with(variant, effects, shots, seed=seed, rx_s=_RX_S[variant])
    began = time.perf_counter()
    found = diagnose_shots(data, model_named(variant))
    report = diagnosis_report(found)
    left_out = {one.shot.name for one in found.refused}
    truths = [t for shot, t in zip(data, truths, strict=True) if shot.name not in left_out]
    truth = {name: float(np.mean([t[name] for t in truths])) for name in _COMPARED if truths[0].get(name) is not None}
    return Row(effects, report, truth, time.perf_counter() - began)


def main() -> None:
    """A row for each resonator, then the shares."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--variant", choices=["jewel", "thread"], default="jewel")
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--shots", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1, help="of the first resonator; the others follow")
    args = parser.parse_args()
    rows = []
    for seed in range(args.seed, args.seed + args.count):
        rows.append(diagnosed_resonator(args.variant, seed, args.shots))
        print(f"{seed}: {rows[-1].text()}", flush=True)
    count = len(rows)
    print(
        f"{args.variant}: of {count} named {sum(r.named for r in rows)}, a false name in {sum(r.false for r in rows)}, "
        f"N50 and D30 agree in {sum(r.agrees for r in rows)}, "
        f"all parameters within {_WITHIN:g} errors in {sum(r.farthest[0] < _WITHIN for r in rows)}"
    )


if __name__ == "__main__":
    main()
