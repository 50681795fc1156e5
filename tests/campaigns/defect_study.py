"""Drawn manufacturing errors of simulated rotors: are they named, and are their sizes and the constants true?

Each shot goes through the whole simulated receive chain and is diagnosed as `platform-daemon diagnose` does, in this
process.  Perfect rotors of five degrees of freedom are among them, of which no error may be named.  Where a recording
tells no drive and no resonator, the motion begins in any state, and the magnets are those of the shipped resonator.
python -m tests.campaigns.defect_study [--without-drive] [--section FILE]
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
import tomllib
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from drivers.specimen import Specimen
from platform_daemon.core.settings import load_specimen
from platform_daemon.diagnosis.diagnose import DiagnosisError, diagnose_shots
from platform_daemon.diagnosis.report import diagnosis_report
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.estimation.noise.series import SeriesNoise
from platform_daemon.estimation.physics.models import model_named
from platform_daemon.estimation.physics.rigid_rotor.rotor import CoilDrive
from platform_daemon.estimation.physics.rotation import rotation_from_rodrigues
from platform_daemon.estimation.rotor_fit.shot import RotorContext
from platform_daemon.features.fit.known_weight import weight_over_pull
from platform_daemon.features.fit.rotor_context import rotor_geometry
from sim_backend.study import play
from tests.kit.data import CONFIG
from tests.kit.simulated_bench import CLOCK, SWITCH, TX, Bench, timeline
from tests.kit.undeclared_shots import calibrated_record

KINDS = {
    "thread": ("stator_tilt", "rotor_tilt", "lateral_displacement"),
    "jewel": ("stator_tilt", "jewel_tilt", "lateral_displacement"),
}
THRESHOLD_UT = {"thread": 270.0, "jewel": 610.0}  # fields from which side modes were seen (paper)
CONSTANTS = ("f_nat_hz", "m_r_am2", "lambda_per_s", "tf_over_i_rad_per_s2")
SURE = 3.0  # standard errors within which a number counts as true
NONE = "none"
PERIODS = 10  # of the drive
GAIN = 40.0  # of the LNA, V/V


@dataclass(frozen=True)
class Case:
    """kind: of the error, or "none"; size: rad, a displacement in m; friction: times the shipped T_f/I."""

    bearing: str
    kind: str
    size: float
    field_ut: float
    friction: float
    seed: int


@dataclass(frozen=True)
class Outcome:
    """What `diagnose` said: verdict, names, look-alikes; size of the named error and of each constant off the truth, in
    standard errors; size: None where another kind is named; chi2: per degree of freedom on held-out data."""

    case: Case
    verdict: str
    names: tuple[str, ...]
    alike: tuple[str, ...]
    size: float | None
    constants: dict[str, float]
    chi2: float | None
    seconds: float
    """Of processor time."""

    @property
    def rotor_named(self) -> bool:
        """An error of manufacture is among the names."""
        return bool({*self.names} & {*KINDS["thread"], *KINDS["jewel"]})

    @property
    def kind_right(self) -> bool:
        """Named or in the declared set; of a perfect rotor: no error of manufacture named."""
        return not self.rotor_named if self.case.kind == NONE else self.case.kind in {*self.names, *self.alike}

    @property
    def numbers_right(self) -> bool:
        """Size, where this kind is named, and constants within three standard errors."""
        return all(abs(off) < SURE for off in [*self.constants.values(), self.size or 0.0])


def drawn(count: int, perfect: int, seed: int) -> list[Case]:
    """Cases with an error, both bearings in turn, and perfect ones."""
    rng = np.random.default_rng(seed)
    found = []
    for k in range(count + perfect):
        bearing = ("thread", "jewel")[k % 2]
        kind = str(rng.choice(KINDS[bearing])) if k < count else NONE
        size = rng.uniform(2e-5, 3e-4) if kind == "lateral_displacement" else math.radians(rng.uniform(0.2, 3.0))
        found.append(
            Case(
                bearing=bearing,
                kind=kind,
                size=float(size) * int(rng.choice([-1, 1])) if k < count else 0.0,
                field_ut=float(THRESHOLD_UT[bearing] * rng.uniform(0.3, 1.0)),
                friction=float(rng.uniform(0.8, 1.2)),
                seed=seed + k,
            )
        )
    return found


def resonator_text(case: Case) -> str:
    """The shipped imperfect resonator with the drawn error in the place of its own, as TOML."""
    lines = (CONFIG / "resonators" / f"{case.bearing}_imperfect.toml").read_text(encoding="utf-8").splitlines()
    kept = lines[: lines.index("[defects]")]
    if case.bearing == "jewel":
        shipped = tomllib.loads("\n".join(lines))["measured"]["tf_over_i_rad_per_s2"]
        at = next(n for n, line in enumerate(kept) if line.startswith("tf_over_i"))
        kept[at] = f"tf_over_i_rad_per_s2 = {shipped * case.friction}"
    key, value = f"{case.kind}_rad", str(case.size)
    if case.kind == "lateral_displacement":
        key, value = "stator_offset_m", f"[{case.size}, 0.0]"
    return "\n".join([*kept, *([] if case.kind == NONE else ["[defects]", f"{key} = {value}"]), ""])


def specimen_of(case: Case) -> Specimen:
    """The resonator."""
    return Specimen.model_validate(tomllib.loads(resonator_text(case)))


def shot_of(case: Case, rx_s: float, *, driven: bool) -> tuple[DiagnosisShot, dict[str, Any]]:
    """A shot from rest as the diagnosis takes it, and its truth; driven: the drive and the resonator are known."""
    specimen = specimen_of(case)
    bench = Bench(None, seed=case.seed)
    program = timeline(bench.channels[0], 1e-6 * case.field_ut, rx=int(rx_s * CLOCK.rate_hz), periods=PERIODS)
    (shot,) = play(bench.backend, specimen, program, shots=1, lna_gain=GAIN)
    record, noise = calibrated_record(bench, shot.volts), SeriesNoise()
    noise.learn(record)
    known = driven_context(specimen, case)
    if not driven:
        known = RotorContext(geometry=rotor_geometry(load_specimen(case.bearing)[0]), drive=None, rotation=None)
    model, sensitivity = noise.for_shot(record).model, np.asarray(bench.calibration.sensitivity)
    assert model is not None
    return DiagnosisShot("shot", record, model, sensitivity, rotor=known), shot.truth


def driven_context(specimen: Specimen, case: Case) -> RotorContext:
    """What a recording of such a shot tells of rotor and drive."""
    return RotorContext(
        geometry=rotor_geometry(specimen),
        drive=CoilDrive(
            field_t=(1e-6 * case.field_ut, 0.0, 0.0),
            frequency_hz=PERIODS * CLOCK.rate_hz / TX,
            phase_rad=0.0,
            duration_s=TX / CLOCK.rate_hz,
            rx_start_s=(TX + SWITCH) / CLOCK.rate_hz,
        ),
        rotation=rotation_from_rodrigues(np.array(specimen.pose.rodrigues_rad)),
    )


def outcome(case: Case, rx_s: float, *, driven: bool) -> Outcome:
    """Measure and diagnose."""
    shot, truth = shot_of(case, rx_s, driven=driven)
    began_s = time.process_time()
    try:
        share = weight_over_pull(specimen_of(case)) if driven else 0.0
        found = diagnose_shots([shot], model_named(case.bearing).under_weight(share))
    except DiagnosisError:
        return Outcome(case, "refused", (), (), None, {}, None, time.process_time() - began_s)
    return judged(case, diagnosis_report(found, seconds=time.process_time() - began_s).model_dump(mode="json"), truth)


def judged(case: Case, report: dict[str, Any], truth: dict[str, Any]) -> Outcome:
    """A report against the truth."""
    named = {e["id"]: e["strength"] for e in report["effects"]}
    after = report["parameters_after"]
    size = (named[case.kind]["value"] - case.size) / named[case.kind]["std"] if case.kind in named else None
    return Outcome(
        case,
        report["verdict"],
        tuple(named),
        tuple(i for e in report["effects"] for i in e["indistinguishable_from"]),
        size,
        {n: (after[n]["value"] - truth[n]) / after[n]["std"] for n in CONSTANTS if n in after and after[n]["std"]},
        report["held_out"]["chi2_per_dof_after"],
        report["seconds"],
    )


def row(found: Outcome) -> str:
    """Of the table."""
    c = found.case
    size = f"{1e3 * c.size:.3f} mm" if c.kind == "lateral_displacement" else f"{math.degrees(c.size):.3f}°"
    names = ", ".join(found.names) or "none"
    alike = f" (or {', '.join(found.alike)})" if found.alike else ""
    off = " ".join(f"{value:+.1f}" for value in found.constants.values())
    error = c.kind if c.kind == NONE else f"{c.kind} {size}"
    return (
        f"| {c.bearing} | {error} | {c.field_ut:.0f} | {found.verdict}: {names}{alike} | "
        f"{'-' if found.size is None else f'{found.size:+.1f}'} | {off} | "
        f"{'-' if found.chi2 is None else f'{found.chi2:.3f}'} | {found.seconds:.0f} |"
    )


def section(outcomes: Sequence[Outcome], rx_s: float, *, driven: bool) -> str:
    """Of the page."""
    faulty = [o for o in outcomes if o.case.kind != NONE]
    perfect = [o for o in outcomes if o.case.kind == NONE]
    title = "Recordings that tell the resonator and the drive" if driven else "Recordings that tell neither"
    way = "" if driven else " --without-drive"
    return "\n".join(
        [
            f"## {title}",
            "",
            f"One shot of {rx_s:g} s each; `make defect-study DEFECTS='--errors {len(faulty)} --perfect {len(perfect)}"
            f"{way}'`.",
            "",
            f"* Kind named or in the declared set: {sum(o.kind_right for o in faulty)} of {len(faulty)}.",
            f"* Size, where the kind is named, and constants within {SURE:g} standard errors: "
            f"{sum(o.rotor_named and o.numbers_right for o in faulty)} of {len(faulty)}.",
            f"* Perfect rotors without such a name: {sum(o.kind_right for o in perfect)} of {len(perfect)}.",
            "",
            "| bearing | error | field / µT | diagnosis | size | constants | held-out χ²/dof | s |",
            "|---|---|---|---|---|---|---|---|",
            *(row(o) for o in outcomes),
            "",
        ]
    )


def main() -> int:
    """Run it; print each case."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--errors", type=int, default=6)
    parser.add_argument("--perfect", type=int, default=2)
    parser.add_argument("--rx-s", type=float, default=2.0)
    parser.add_argument("--seed", type=int, default=40)
    parser.add_argument("--without-drive", action="store_true", help="recordings that tell no drive and no resonator")
    parser.add_argument("--section", type=Path, help="write this section of the page here")
    parser.add_argument("--journal", type=Path, help="keep outcomes in this file, and go on after those it holds")
    asked = parser.parse_args()
    known: dict[Case, Outcome] = {}
    if asked.journal and asked.journal.exists():
        for line in asked.journal.read_text(encoding="utf-8").splitlines():
            held = json.loads(line)
            case = Case(**held["case"])
            known[case] = Outcome(
                **{**held, "case": case, "names": tuple(held["names"]), "alike": tuple(held["alike"])}
            )
    outcomes = []
    for case in drawn(asked.errors, asked.perfect, asked.seed):
        if case not in known:
            known[case] = outcome(case, asked.rx_s, driven=not asked.without_drive)
            if asked.journal:
                with asked.journal.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(asdict(known[case])) + "\n")
        outcomes.append(known[case])
        print(row(outcomes[-1]), flush=True)
    if asked.section:
        text = section(outcomes, asked.rx_s, driven=not asked.without_drive)
        asked.section.write_text(text, encoding="utf-8")
    return 0 if all(o.kind_right for o in outcomes) else 1


if __name__ == "__main__":
    sys.exit(main())
