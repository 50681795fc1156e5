"""Command line: what a design says, and what manufacturing defects do."""

from __future__ import annotations

from tests.system.golden.workplace import Workplace


def design(place: Workplace) -> None:
    """`design` and `defects` of both bearings."""
    place.case("design-paper", "design", "--json", "design-paper.json")
    for name in ("jewel", "thread"):
        place.case(f"design-{name}", "design", "--resonator", name, "--json", f"design-{name}.json")
    for bearing, defect, *sizes in (
        ("jewel", "stator_tilt", "--eps-deg", "0,0.36,2,10"),
        ("jewel", "jewel_tilt", "--eps-deg", "2,10", "--pivot", "rotor_centre"),
        ("jewel", "lateral", "--dy-mm", "0.1,1", "--cup-radius-over-r", "4"),
        ("thread", "stator_tilt", "--eps-deg", "0,0.32,2,10", "--resonator", "thread"),
        ("thread", "rotor_tilt", "--eps-deg", "2,10", "--thread-length-over-r", "inf"),
        ("thread", "lateral", "--dy-mm", "0.1,1"),
    ):
        name = f"{bearing}-{defect}"
        more = ("--phi-deg", "10,30,60", "--json", f"{name}.json")
        place.case(name, "defects", "--bearing", bearing, "--defect", defect, *sizes, *more)
    place.case("sweep", "defects", "--bearing", "jewel", "--defect", "stator_tilt", "--eps-deg", "0:10:100",
               "--phi-deg", "0:90:100", "--png", "sweep.png")  # fmt: skip
