"""Which distances of a rotor from the centre of its coils a budget names, and how right they are.

python -m tests.campaigns.off_centre [--shots N] [--page FILE]

The field of the pairs at a place mixes the channels of a simulated shot, which is fitted; its budget then says whether
the rotor is off centre and how far, once with gains and angles as the shipped platform declares them and once with
those of a better calibration.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import platform_daemon as pd_
from drivers.uncertainty import DeclaredUncertainty
from platform_daemon.features.budget.influences import pair_fields
from platform_daemon.features.budget.work import shot_budgets
from platform_daemon.features.fit.fit_request import FitRequest
from tests.campaigns.uncertainty_coverage import RADII, RATE_HZ

DIRECTIONS = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}
MILLIMETRES = (0, 8, 12, 16, 20, 24)
COILS = {"shipped": (1e-3, 3.5e-3), "better": (3e-4, 3e-4)}
"""Standard uncertainty of the gains, relative, and of the angles of the coils, rad."""


@dataclass(frozen=True)
class Told:
    """What a budget says of one shot: seen, and the distance, mm."""

    seen: bool
    distance_mm: float | None


def told_at(direction: str, distance_mm: float, seed: int) -> dict[str, Told]:
    """What is said of a jewel there, by what is declared of the coils."""
    axis = np.array(DIRECTIONS[direction], float)
    place = 1e-3 * distance_mm * axis
    made = pd_.simulate("jewel", phi_max_deg=40.0, seconds=0.8, seed=seed, sampling_rate_hz=RATE_HZ)
    samples = pair_fields(place, RADII) @ made.signal(0)
    again = pd_.from_arrays(np.arange(samples.shape[1]) / RATE_HZ, samples, variant="jewel")
    fit = pd_.fit(again, window=0.6).result
    found = {}
    for name, (gain, angle) in COILS.items():
        said = DeclaredUncertainty.model_validate(
            {"coil_radius_m": list(RADII), "gain": {"u": gain}, "orthogonality_rad": {"u": angle}}
        )
        off = shot_budgets(again.measurement, 0, FitRequest("jewel", 0.6), fit=fit, declared=said).off_centre
        assert off is not None
        found[name] = Told(off.seen, None if off.distance_m is None else 1e3 * off.distance_m)
    return found


def cell(told: list[Told]) -> str:
    """How often it is named, and the distances from and to, mm."""
    named = [each.distance_mm for each in told if each.seen and each.distance_mm is not None]
    if not named:
        return "no"
    where = f"{min(named):.1f} to {max(named):.1f}" if len(named) > 1 else f"{named[0]:.1f}"
    return where if len(named) == len(told) else f"{where} ({len(named)} of {len(told)})"


def page(shots: int) -> str:
    """The page of evidence."""
    lines = [
        "# Which distances from the centre are named",
        "",
        "A jewel in Helmholtz pairs with radii of 50, 57 and 65 mm, at a distance from the centre along an",
        f"axis; {shots} simulated shots of 0.8 s for each place, whose channels are mixed by the field of the",
        "pairs there and fitted. Distances in mm that the budgets name, “no” where none is named; once with",
        "the gains and angles of the shipped platform (1e-3, 3.5 mrad), once with those of a better",
        "calibration (3e-4, 0.3 mrad):",
    ]
    table: dict[tuple[str, str, int], str] = {}
    for direction in DIRECTIONS:
        for distance in MILLIMETRES:
            told = [told_at(direction, distance, seed) for seed in range(shots)]
            for name in COILS:
                table[name, direction, distance] = cell([each[name] for each in told])
            print(direction, distance, *(table[name, direction, distance] for name in COILS), flush=True)
    lines += ["", f"| coils | direction | {' | '.join(f'{d} mm' for d in MILLIMETRES)} |"]
    lines += [f"|---|---|{'---|' * len(MILLIMETRES)}"]
    for name in COILS:
        for direction in DIRECTIONS:
            cells = " | ".join(table[name, direction, distance] for distance in MILLIMETRES)
            lines.append(f"| {name} | {direction} | {cells} |")
    return "\n".join([*lines, ""])


def main() -> None:
    """Make the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--shots", type=int, default=2)
    parser.add_argument("--page", type=Path)
    asked = parser.parse_args()
    text = page(asked.shots)
    print(text)
    if asked.page is not None:
        asked.page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
