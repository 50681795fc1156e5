"""How true the fits of simulated shots are: errors against the truth in units of the reported standard deviation.

As a program it runs the whole campaign and writes docs/evidence/accuracy.md:  python -m tests.campaigns.accuracy
"""

from __future__ import annotations

import argparse
import math
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recording import Recording
from platform_daemon.core.recordings.truth import read_truth
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.core.settings import load_platform
from platform_daemon.features.acquire.destination import OwnFile
from platform_daemon.features.acquire.series_plan import plan_series, series_work
from platform_daemon.features.fit.fit import fit_frame
from platform_daemon.features.fit.fit_request import FitRequest
from platform_daemon.processes.assembly import start_engine
from tests.kit.data import ROOT

DOCUMENT = ROOT / "docs" / "evidence" / "accuracy.md"
RX_S = {"thread": 6.0, "jewel": 2.0}
"""RX windows: long enough for D30 (4.9 s and about 1.3 s); the thread's next shot then starts from 23 % of the last."""


@dataclass(frozen=True)
class Accuracy:
    """Shots of one variant and chain: pulls (shot, parameter), joint chi2 per shot with its degrees of freedom."""

    variant: str
    chain: str
    names: tuple[str, ...]
    pulls: NDArray[np.float64]
    joint: NDArray[np.float64]
    chi2_per_dof: NDArray[np.float64]
    seconds: NDArray[np.float64]

    @property
    def shots(self) -> int:
        """Number of good shots."""
        return len(self.joint)

    def joint_below(self, share: float = 0.997) -> int:
        """Shots whose joint chi2 lies below that quantile."""
        return int(np.sum(self.joint < chi2.ppf(share, len(self.names))))

    def within(self, sigmas: float = 3.0) -> dict[str, int]:
        """Shots per parameter whose error is below so many reported standard deviations."""
        return dict(zip(self.names, np.sum(np.abs(self.pulls) < sigmas, axis=0).tolist(), strict=True))


def record(variant: str, chain: str, shots: int, target: Path, seed: int = 1) -> Recording:
    """A series on the simulated platform with the named receive chain."""
    chosen = [f"backends.simulated.receive.chain={chain!r}", f"backends.simulated.seed={seed}"]
    engine = start_engine(load_platform("simulated", chosen))
    try:
        asked = {"resonator": variant, "shots": shots, "sequence": {"rx_s": RX_S[variant]}, "window": None}
        job = engine.submit(
            series_work(engine, plan_series(engine, AcquisitionRequest(**asked)), OwnFile(target, target.parent))
        )  # type: ignore[arg-type]
        job.ended.wait()
        if job.error is not None:
            raise job.error
    finally:
        engine.close()
    return open_recording(target)


def judge(recording: Recording, chain: str, *, corrected: bool = True) -> Accuracy:
    """Fit every frame over D30 and compare with the truth; `corrected=False` leaves the frequency response out."""
    assert recording.variant is not None
    assert recording.calibration is not None
    calibration = recording.calibration
    if not corrected:
        calibration = replace(calibration, frequency_hz=None, frequency_response=None)
    rows, names = [], ()
    for k, truth in enumerate(_truths(recording.path)):
        fit = fit_frame(
            recording.rx_volts(k), recording.sequence.rate_hz, calibration, FitRequest(recording.variant, "d30")
        )
        if fit.verdict != "good":
            raise AssertionError(f"{recording.path} frame {k}: {fit.reason}")
        names = tuple(fit.covariance_names)
        error = np.array([_error(n, fit.parameters[n].value, truth[n]) for n in names])
        joint = float(error @ np.linalg.solve(fit.covariance, error))
        rows.append((error / np.sqrt(np.diag(fit.covariance)), joint, fit.chi2_per_dof, fit.seconds))
    pulls, joints, quality, seconds = (np.array(column) for column in zip(*rows, strict=True))
    return Accuracy(recording.variant, chain, names, pulls, joints, quality, seconds)


def _truths(path: Path) -> Iterator[dict[str, float]]:
    for truth in read_truth(path) or []:
        yield next(iter(truth.values()))


def _error(name: str, found: float, true: float) -> float:
    return math.remainder(found - true, 2 * math.pi) if name == "psi_start_rad" else found - true


def table(results: list[Accuracy]) -> str:
    """Markdown: one row per series."""
    lines = [
        "| resonator | receive chain | shots | joint χ² below its 99.7 % quantile | fewest shots within 3 σ "
        "| mean pull, largest of all parameters | m_r, mean pull | scatter of pulls | χ²/dof, mean | fit, median s |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for r in results:
        name, fewest = min(r.within().items(), key=lambda item: item[1])
        mean = r.pulls.mean(axis=0)
        worst = int(np.argmax(np.abs(mean)))
        moment = mean[r.names.index("m_r_am2")]
        lines.append(
            f"| {r.variant} | {r.chain} | {r.shots} | {r.joint_below()} | {fewest} ({name}) "
            f"| {mean[worst]:+.2f} σ ({r.names[worst]}) | {moment:+.2f} σ | {r.pulls.std():.3f} σ "
            f"| {r.chi2_per_dof.mean():.4f} | {np.median(r.seconds):.3f} |"
        )
    return "\n".join(lines)


TEXT = """# How true the fits are

{shots} shots per row on the simulated platform (seed 1, shipped resonators, default variation of temperature and
friction from shot to shot), window D30, against the simulated truth. Written by `make accuracy` ({seconds:.0f} s
on this machine).

{table}

*Pull*: (fit - truth) / reported standard deviation. *Joint χ²*: of all parameter errors with the full covariance,
8 (thread) or 9 (jewel) degrees of freedom; 99.7 shots of 100 are expected below the 99.7 % quantile. With {shots}
shots the mean pull scatters by {expected:.2f} σ by itself.

The *non_ideal* chain has a 20 kHz pole (a little different in each channel) and a quarter sample of delay. Its
response is part of the calibration, and the fit corrects for it. *Uncorrected* shows the same recordings with the
response left out of the calibration: the bias is real (the delay turns the start phase, the pole lowers the moment),
and a fit without frequency response must not be trusted to its statistical error.
"""


def main() -> None:
    """Run everything and write the document."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shots", type=int, default=100, help="per resonator and receive chain")
    parser.add_argument("--out", type=Path, default=DOCUMENT)
    options = parser.parse_args()
    options.out.write_text(document(options.shots), encoding="utf-8")


def document(shots: int) -> str:
    """The whole page; tells the rows as they come."""
    started, results = time.monotonic(), []
    with tempfile.TemporaryDirectory() as folder:
        for variant in ("jewel", "thread"):
            for chain in ("ideal", "non_ideal"):
                recording = record(variant, chain, shots, Path(folder) / f"{variant}-{chain}.h5")
                results.append(judge(recording, chain))
            results.append(judge(recording, "non_ideal, uncorrected", corrected=False))
            print(table(results), flush=True)
    seconds = time.monotonic() - started
    return TEXT.format(shots=shots, seconds=seconds, table=table(results), expected=shots**-0.5)


if __name__ == "__main__":
    main()
