"""What the errors of many fits look like: scatter at the Cramer-Rao bound, no bias, honest intervals, no failures.

As a program it draws everything and writes docs/evidence/estimator-statistics.md:
python -m tests.campaigns.estimator_statistics
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
import pickle
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import repeat
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import binom, chi2, norm

from platform_daemon.estimation.cramer_rao import MeasurementPlan, planned_window_s, predict_precision
from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.result import FitResult
from tests.kit.data import ROOT
from tests.kit.paper_datasets import DATASETS
from tests.kit.ring_down_generator import NOISE_SD, RATE_HZ, Truth, dmdt, errors, random_truth, with_noise

DOCUMENT = ROOT / "docs" / "evidence" / "estimator-statistics.md"
SHARES = (math.erf(1.0 / math.sqrt(2.0)), 0.95)
FLOOR = 0.05  # relative error of m_r beyond which a result must be refused
NEAR = (0.03, 0.08)  # predicted errors for which the estimated one may fall on either side of the floor
_BEYOND = 1e-9  # probability of a joint chi2 that no honest error explains
_CHUNK = 25


def fit(signal: np.ndarray, variant: str, scale: float = 1.0, *, own_noise: bool = False) -> FitResult:
    """Fit all of a dm/dt record (3, n); its noise is the paper's times `scale`, told to the fit or not."""
    noise = None if own_noise else NoiseModel.white(scale * NOISE_SD, RATE_HZ)
    record = RingDownRecord(signal, RATE_HZ, "dmdt")
    return fit_ring_down(record, variant, signal.shape[1] / RATE_HZ, noise=noise)


@dataclass(frozen=True)
class Scatter:
    """Draws of one dataset: misses and reported stds (draws, k), bound (k,): stds of the noise-free record's fit."""

    name: str
    names: tuple[str, ...]
    bound: np.ndarray
    misses: np.ndarray
    stds: np.ndarray
    refused: tuple[str, ...]

    @property
    def ratio(self) -> np.ndarray:
        """Standard deviation over Cramer-Rao bound, (k,)."""
        return np.asarray(self.misses.std(axis=0) / self.bound)

    @property
    def bias(self) -> np.ndarray:
        """Mean error in standard deviations, (k,)."""
        return np.asarray(self.misses.mean(axis=0) / self.bound)

    def coverage(self, share: float) -> np.ndarray:
        """Share of draws whose interval of nominal `share` holds the truth, (k,)."""
        return np.asarray(np.mean(np.abs(self.misses) < norm.ppf(0.5 + 0.5 * share) * self.stds, axis=0))

    def room(self, share: float) -> float:
        """Four binomial standard deviations."""
        draws = len(self.misses)
        return float(4.0 * binom(draws, share).std() / draws)

    def complaints(self) -> list[str]:
        """What is out of its limits, which grow where the draws are too few to reach them."""
        draws = len(self.misses)
        found = [f"{self.name}: refused: {reason}" for reason in self.refused]
        for k, name in enumerate(self.names):
            if abs(self.ratio[k] - 1.0) > max(0.05, 4.0 / math.sqrt(2.0 * draws)):
                found.append(f"{self.name}, {name}: std/bound {self.ratio[k]:.3f}")
            if abs(self.bias[k]) > max(0.1, 4.0 / math.sqrt(draws)):
                found.append(f"{self.name}, {name}: bias {self.bias[k]:+.3f} sigma")
            for share in SHARES:
                if abs(self.coverage(share)[k] - share) > self.room(share):
                    found.append(f"{self.name}, {name}: {self.coverage(share)[k]:.4f} instead of {share:.4f}")
        return found


Each = Callable[[Callable[..., Any], Sequence[Any]], Iterator[Any]]
"""How work is spread: calls a function with every tuple of arguments."""


def one_by_one(work: Callable[..., Any], arguments: Sequence[Any]) -> Iterator[Any]:
    """In this process."""
    return (work(*args) for args in arguments)


def draw(name: str, seeds: range, own_noise: bool) -> list[tuple[np.ndarray, np.ndarray] | str]:
    """Errors and reported standard deviations of every draw, or why it was refused."""
    variant, truth, seconds = DATASETS[name]
    clean = dmdt(truth, seconds)
    found: list[tuple[np.ndarray, np.ndarray] | str] = []
    for seed in seeds:
        result = fit(with_noise(clean, np.random.default_rng(seed)), variant, own_noise=own_noise)
        good = result.verdict == "good"
        found.append((errors(result, truth), np.sqrt(np.diag(result.covariance))) if good else str(result.reason))
    return found


def scatter(name: str, draws: int, *, own_noise: bool = False, each: Each = one_by_one) -> Scatter:
    """Draw a dataset so often."""
    variant, truth, seconds = DATASETS[name]
    exact = fit(dmdt(truth, seconds), variant)
    rows = [row for rows in each(draw, list(zip(repeat(name), _chunks(draws), repeat(own_noise)))) for row in rows]
    good = [row for row in rows if not isinstance(row, str)]
    refused = tuple(row for row in rows if isinstance(row, str))
    bound = np.sqrt(np.diag(exact.covariance))
    misses, stds = (np.array([row[i] for row in good]) for i in (0, 1))
    return Scatter(name, exact.covariance_names, bound, misses, stds, refused)


def _chunks(count: int) -> list[range]:
    return [range(k, min(k + _CHUNK, count)) for k in range(0, count, _CHUNK)]


@dataclass(frozen=True)
class Outcome:
    """One random truth: the predicted relative error of m_r, from the truth to a good fit, the fall of chi2."""

    seed: int
    predicted: float
    reason: str | None
    joint: float
    parameters: int

    @property
    def failed(self) -> bool:
        """Refused though it can be told, accepted though it cannot, or wrong beyond its errors."""
        floor = self.reason is not None and self.reason.startswith("amplitude_below_floor")
        near = NEAR[0] < self.predicted < NEAR[1]
        if self.reason is not None:
            return not (floor and (near or self.predicted > FLOOR))
        return (self.predicted > FLOOR and not near) or chi2.sf(self.joint, self.parameters) < _BEYOND


def try_truths(variant: str, scale: float, window: str, seeds: range) -> list[Outcome]:
    """Fit random resonators: 100-1000 Hz, 2-75 deg, any orientation and phase."""
    found = []
    for seed in seeds:
        rng = np.random.default_rng((seed, int(scale)))
        truth = random_truth(rng, variant, (100.0, 1000.0), (2.0, 75.0))
        predicted, seconds = _predicted(variant, truth, scale, window)
        clean, sd = dmdt(truth, seconds), scale * NOISE_SD
        signal = with_noise(clean, rng, sd)
        result = fit(signal, variant, scale)
        joint = _fall(result, signal - clean, sd) if result.verdict == "good" else math.nan
        found.append(Outcome(seed, predicted, result.reason, joint, len(result.covariance_names)))
    return found


def _fall(result: FitResult, noise: np.ndarray, sd: np.ndarray) -> float:
    """How much chi2 falls from the truth, which leaves `noise` (3, n), to the fit: chi2 with as many degrees as names.

    Errors themselves will not do: a small oscillation tells the product of moment and angle a hundred times better than
    either, and a straight line leaves the allowed curve within one standard deviation.
    """
    left = noise - noise.mean(axis=1, keepdims=True)
    degrees = 3 * result.samples - len(result.covariance_names) - 3
    assert result.chi2_per_dof is not None
    return float(np.sum((left / sd[:, None]) ** 2)) - result.chi2_per_dof * degrees


def _predicted(variant: str, truth: Truth, scale: float, window: str) -> tuple[float, float]:
    """Smallest relative error of m_r that the window allows, and the window in s."""
    names = ["f_nat_hz", "m_r_am2", "lambda_per_s", "phi_max_rad", "psi_start_rad"]
    names += ["rodrigues_x", "rodrigues_y", "rodrigues_z", *(["tf_over_i_rad_per_s2"] if variant == "jewel" else [])]
    plan = MeasurementPlan(variant, {name: truth.value(name) for name in names}, scale * NOISE_SD, RATE_HZ)
    seconds = planned_window_s(plan, window)
    return predict_precision(plan, seconds).sd["m_r_am2"] / truth.m_r_am2, seconds


def outcomes(variant: str, scale: float, window: str, truths: int, each: Each = one_by_one) -> list[Outcome]:
    """Try so many random truths."""
    asked = list(zip(repeat(variant), repeat(scale), repeat(window), _chunks(truths)))
    return [outcome for found in each(try_truths, asked) for outcome in found]


def scatter_table(found: Scatter) -> str:
    """Markdown rows of one dataset."""
    rows = []
    for k, name in enumerate(found.names):
        inside = " | ".join(f"{found.coverage(share)[k]:.4f}" for share in SHARES)
        rows.append(f"| {found.name} | {name} | {found.ratio[k]:.3f} | {found.bias[k]:+.3f} | {inside} |")
    return "\n".join(rows)


def scatter_section(title: str, found: list[Scatter]) -> str:
    """Markdown of all datasets."""
    draws = len(found[0].misses) + len(found[0].refused)
    limits = ", ".join(f"{100.0 * share:.1f} % ± {100.0 * found[0].room(share):.2f} %" for share in SHARES)
    head = "| dataset | parameter | std / Cramer-Rao | bias / σ | in 68 % | in 95 % |\n|---|---|---|---|---|---|"
    refused = sum(len(f.refused) for f in found)
    note = f"{draws} draws per dataset, {refused} refused. Limits: 0.95-1.05, 0.1 σ, {limits} (4 binomial σ)."
    return "\n".join([f"## {title}", "", note, "", head, *(scatter_table(f) for f in found)])


def truths_row(variant: str, scale: float, window: str, found: list[Outcome]) -> str:
    """Markdown row of one set of random truths."""
    told = [o for o in found if o.predicted <= FLOOR]
    good = [o for o in found if o.reason is None]
    mean = np.mean([o.joint / o.parameters for o in good])
    failed = sum(o.failed for o in found)
    weak = len(found) - len(told)
    return f"| {variant} | {window} | {scale:g} | {len(found)} | {weak} | {len(good)} | {failed} | {mean:.3f} |"


class _Pool:
    """Processes that share the work and tell how far it is; what is done stays in a folder, as pickles by arguments."""

    def __init__(self, processes: int, journal: Path) -> None:
        self._pool, self._journal = multiprocessing.get_context("spawn").Pool(processes), journal

    def __call__(self, work: Callable[..., Any], arguments: Sequence[Any]) -> Iterator[Any]:
        files = [self._journal / f"{work.__name__}-{'-'.join(map(_text, args))}.pkl" for args in arguments]
        missing = [args for args, file in zip(arguments, files, strict=True) if not file.exists()]
        fresh, began, done = self._pool.imap(_call, [(work, args) for args in missing]), time.monotonic(), 0
        for file in files:
            if not file.exists():
                part = file.with_suffix(".part")
                part.write_bytes(pickle.dumps(next(fresh)))
                part.replace(file)
                done += 1
                left = (time.monotonic() - began) * (len(missing) - done) / done
                print(f"\r{file.stem}: {done}/{len(missing)}, {left:.0f} s left   ", end="", file=sys.stderr)
            yield pickle.loads(file.read_bytes())
        print(file=sys.stderr)


def _text(argument: Any) -> str:
    return f"{argument.start}_{argument.stop}" if isinstance(argument, range) else str(argument)


def _call(task: tuple[Callable[..., Any], Any]) -> Any:
    return task[0](*task[1])


def run(draws: int, own_draws: int, truths: dict[str, int], each: Each) -> tuple[str, list[str]]:
    """The document's sections, and what is out of limits; truths: how many by window."""
    given = [scatter(name, draws, each=each) for name in DATASETS]
    own = [scatter(name, own_draws, own_noise=True, each=each) for name in DATASETS]
    complaints = [c for f in (*given, *own) for c in f.complaints()]
    rows = []
    for variant in ("thread", "jewel"):
        for window, count in truths.items():
            for scale in (1.0, 10.0):
                found = outcomes(variant, scale, window, count, each)
                rows.append(truths_row(variant, scale, window, found))
                complaints += [f"{variant} {window} x{scale:g}: {o}" for o in found if o.failed]
    sections = [
        scatter_section("Noise known, as from a series", given),
        scatter_section("Noise estimated from the record itself", own),
        _TRUTHS + "\n".join(rows),
    ]
    return "\n\n".join(sections), complaints


_INTRODUCTION = """# What the errors of the fits look like

Written by `make campaign` (`python -m tests.campaigns.estimator_statistics --draws {draws} --own-draws {own} --truths
{truths} --long-truths {long_truths}`).
Ring-downs come from an independent integrator with white noise of 14, 21 and 55 mA m²/s; every fit starts from what it
finds in the data. JN50, JD30: jewel, first 0.24 s and 1.28 s; TN50, TD30: thread, first 0.24 s and 4.90 s.
The Cramer-Rao bound is the covariance of the exact Jacobian at the truth.

{verdict}
"""

_TRUTHS = """## Random resonators

100-1000 Hz, 2-75 degrees, any orientation and phase. Where the predicted error of m_r is above 5 %, the only right
answer is `amplitude_below_floor`; from 3 to 8 % the estimated error may fall on either side. A failure is any
other refusal, a missing one, or a χ² that falls from the truth to the fit by more than chance lets it
(probability below 10⁻⁹). Mean χ²/k: that fall per parameter, of the good fits; 1 if they are honest.

| variant | window | noise | truths | predicted above 5 % | good | failures | mean χ²/k |
|---|---|---|---|---|---|---|---|
"""


def main() -> int:
    """Run everything, write the document; 1 if something is out of its limits."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=10_000, help="of each dataset")
    parser.add_argument("--own-draws", type=int, default=2000, help="of each, with noise estimated from each record")
    parser.add_argument("--truths", type=int, default=2000, help="per variant and noise, in windows of 0.24 s")
    parser.add_argument("--long-truths", type=int, default=200, help="the same down to 30 %% of the amplitude")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--out", type=Path, default=DOCUMENT)
    parser.add_argument("--journal", type=Path, help="folder that lets an interrupted campaign of the same code go on")
    asked = parser.parse_args()
    truths = {"n50": asked.truths, "d30": asked.long_truths}
    with tempfile.TemporaryDirectory() as made:
        journal = asked.journal or Path(made)
        journal.mkdir(parents=True, exist_ok=True)
        text, complaints = run(asked.draws, asked.own_draws, truths, _Pool(asked.processes, journal))
    verdict = (
        "Everything lies within its limits." if not complaints else "Out of limits:\n\n* " + "\n* ".join(complaints)
    )
    counts = {"draws": asked.draws, "own": asked.own_draws, "truths": asked.truths, "long_truths": asked.long_truths}
    head = _INTRODUCTION.format(**counts, verdict=verdict)
    asked.out.write_text(f"{head}\n{text}\n", encoding="utf-8")
    print(f"{text}\n\n{verdict}")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
