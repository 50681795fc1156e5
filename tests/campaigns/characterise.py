"""Specimens characterised over many shots, beside the truths of their worlds and the time that hardware would take.

    python -m tests.campaigns.characterise thread jewel thread_imperfect jewel_imperfect --shots 100

Prints the tables of docs/explanation/design-and-paper.md.  Fields and windows are the presets': 80 % of the fields at
which the paper saw side modes.  Of a rigid body the truths of f_nat and lambda are those of the main mode in small
motions, defects included; T_f/I is that of a contact that only spins, which a tilted one does not.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean
from typing import Any

from platform_daemon.core.recordings.truth import read_truth
from platform_daemon.core.schemas.parameters import definition_of
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.core.settings import load_platform
from platform_daemon.features.acquire.series_plan import plan_series
from platform_daemon.features.characterise.schema import CharacterisationReport, ParameterUncertainty
from platform_daemon.processes.assembly import start_engine
from tests.kit.command_line import here

TRUTHS = {
    "f_nat_hz": ("main_mode_hz", "f_nat_hz"),
    "m_r_am2": ("m_r_am2",),
    "lambda_per_s": ("main_mode_decay_per_s", "lambda_per_s"),
    "tf_over_i_rad_per_s2": ("tf_over_i_rad_per_s2",),
    "phi_max_rad": ("phi_max_rad",),
}
"""By public name: keys of the truth, the first that there is."""


@dataclass(frozen=True)
class Characterised:
    """A specimen: its report, truths by frame, and seconds of simulating, of computing, and of hardware."""

    name: str
    report: CharacterisationReport
    truths: Sequence[dict[str, Any]]
    measuring_s: float
    computing_s: float
    hardware_s: float


def command(*arguments: str) -> float:
    """Run it, s.  Raises SystemExit with what it said."""
    began = time.perf_counter()
    done = here(*arguments)
    if done.returncode:
        raise SystemExit(f"platform-daemon {' '.join(arguments)}: {done.stderr}")
    return time.perf_counter() - began


def characterised(name: str, shots: int, folder: Path) -> Characterised:
    """Measure and characterise a specimen."""
    recording, result = folder / f"{name}.h5", folder / f"{name}.json"
    series = ("--resonator", name, "--shots", str(shots), "--blank-shots", "4")
    measuring_s = command("measure", *series, "--out", str(recording))
    computing_s = command("characterise", "--from", str(recording), "--json", str(result), "--html", f"{result}.html")
    truths = [one["simulated"] for one in read_truth(recording) or ()]
    recording.unlink()
    report = CharacterisationReport.model_validate_json(result.read_text())
    return Characterised(name, report, truths, measuring_s, computing_s, hardware_s(name, shots))


def hardware_s(name: str, shots: int) -> float:
    """What the plan says that the series takes."""
    engine = start_engine(load_platform("simulated"))
    try:
        return plan_series(engine, AcquisitionRequest(resonator=name, shots=shots, blank_shots=4)).summary().duration_s
    finally:
        engine.close()


def true_mean(found: Characterised, parameter: str) -> float | None:
    """Mean of the truths of the good D30 shots; None: the world has no such thing."""
    frames = [frame.frame for frame in found.report.d30_fits.good_frames]
    keys = [key for key in TRUTHS.get(parameter, ()) if key in found.truths[frames[0]]]
    return fmean(found.truths[k][keys[0]] for k in frames) if keys else None


def truth_row(found: Characterised, row: ParameterUncertainty) -> str | None:
    """A parameter beside its truth, in the unit that people read."""
    true = true_mean(found, row.parameter)
    if true is None or row.uncertainty is None:
        return None
    shown = definition_of(row.parameter)
    f = shown.display_factor
    off = row.value - true
    fit_std = found.report.d30.parameters[row.parameter].fit_std or 0.0
    n50 = found.report.n50.parameters[row.parameter]
    short = "held" if n50.fit_std is None else f"{(n50.mean - true) * f:+.2g}"
    cells = (
        found.name, shown.heading, f"{true * f:.6g}", short, f"{off * f:+.2g}", f"{fit_std * f:.1g}",
        f"{row.uncertainty * f:.2g}", f"{abs(off) / row.uncertainty:.1f}",
    )  # fmt: skip
    return f"| {' | '.join(cells)} |"


def print_tables(all_found: Sequence[Characterised]) -> None:
    """In Markdown."""
    print("| specimen | parameter | truth | N50 − truth | D30 − truth | a fit's own std | uncertainty | off by |")
    print("|---|---|---|---|---|---|---|---|")
    for found in all_found:
        rows = (truth_row(found, row) for row in found.report.uncertainties)
        print("\n".join(row for row in rows if row is not None))
    print("\n| specimen | shots | hardware / s | simulated and fitted on line / s | characterised / s | D30 χ²/dof |")
    print("|---|---|---|---|---|---|")
    for found in all_found:
        d30 = found.report.d30
        times = f"{found.hardware_s:.0f} | {found.measuring_s:.0f} | {found.computing_s:.0f}"
        chi2 = "-" if d30.chi2_per_dof is None else f"{d30.chi2_per_dof.median:.2f}"
        print(f"| {found.name} | {d30.good} of {d30.shots} | {times} | {chi2} |")


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("specimens", nargs="+")
    parser.add_argument("--shots", type=int, default=100)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        print_tables([characterised(name, given.shots, Path(folder)) for name in given.specimens])


if __name__ == "__main__":
    main()
