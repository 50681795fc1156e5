"""Command line: diagnoses, and the models that are adopted from them."""

from __future__ import annotations

import json

from tests.system.golden.cli_platform import FIXED
from tests.system.golden.workplace import Workplace

RUNS = tuple(f"r2_rotary_pendulum_run{k}.h5" for k in (1, 2, 3))
SHOT = ("--resonator", "thread", "--rx-s", "1.0")
# An effect that nobody declared, and nothing else that changes from shot to shot.
HIDDEN = ("--set", 'backends.simulated.undeclared=[{id="coulomb_friction", strength=60.0}]',
          "--set", "backends.simulated.effects.temperature.enabled=false",
          "--set", "backends.simulated.effects.wear.enabled=false", *FIXED)  # fmt: skip


def diagnoses(place: Workplace) -> None:
    """`diagnose` of angles and of a series, `adopt`, `models`, and fits with the adopted model."""
    place.take(*(f"measured/{name}" for name in RUNS))
    place.case("angles", "diagnose", *RUNS, "--json", "angles.json", "--html", "angles.html")
    place.case("angles-based", "diagnose", RUNS[0], "--base", "jewel_constant_friction", "--json", "based.json")
    place.case("measure", "measure", *SHOT, "--shots", "3", "--blank-shots", "1", "--out", "s.h5", *HIDDEN)
    place.case("series", "diagnose", "s.h5", "--json", "series.json")
    place.case("blank", "measure", *SHOT, "--shots", "0", "--blank-shots", "2", "--out", "blank.h5", *HIDDEN)
    place.case("nothing", "diagnose", "blank.h5", "--json", "nothing.json")
    _adopted(place)


def _adopted(place: Workplace) -> None:
    shelf = ("--models", "shelf")
    place.case("models-none", "models", *shelf, "--json", "none.json")
    place.case("adopt", "adopt", "series.json", "--name", "dry", "--by", "me", *shelf)
    place.case("adopt-angles", "adopt", "angles.json", "--name", "swing", "--by", "me",
               "--effect", "coulomb_friction", "--force", "to see it", *shelf)  # fmt: skip
    place.case("adopt-bad-effect", "adopt", "angles.json", "--name", "swing", "--force", "to see it", *shelf)
    free = _first_effect(place, "series.json")
    place.case("adopt-free", "adopt", "series.json", "--name", "dry", "--effect", free, "--free", free, *shelf)
    place.case("models", "models", *shelf, "--json", "models.json")
    place.case("models-show", "models", *shelf, "show", "dry@1")
    place.case("models-retire", "models", *shelf, "retire", "dry@1", "--reason", "tried out")
    place.case("models-show-retired", "models", *shelf, "show", "dry@1")
    place.case("models-after", "models", *shelf, "--json", "after.json")
    for path in sorted((place.folder / "shelf").rglob("*.json")):
        place.keep(f"shelf/{path.name}", path.read_text())
    place.case("fit-adopted", "fit", "s.h5", "--variant", "dry@1", *shelf, "--json", "fit-adopted.json")
    place.case("fit-free", "fit", "s.h5", "--variant", "dry", *shelf, "--json", "fit-free.json")
    place.case("slide-adopted", "slide", "s.h5", "--frame", "1", "--window", "0.25", "--variant", "dry@1", *shelf,
               "--json", "slide-adopted.json")  # fmt: skip
    place.case("bad-unknown-model", "models", *shelf, "show", "wet")
    place.case("bad-retired", "models", *shelf, "retire", "dry@9", "--reason", "none")


def _first_effect(place: Workplace, name: str) -> str:
    found = json.loads((place.folder / name).read_text())["effects"]
    return str(found[0]["id"])


def live(place: Workplace) -> None:
    """`diagnose --live`: the log of its series and the last diagnosis."""
    budget = ("--shots", "3", "--budget-shots", "6", "--budget-s", "600")
    place.case("live", "diagnose", "--live", *SHOT, "--out", "live", *budget, "--json", "live.json", *HIDDEN)
    for path in sorted((place.folder / "live").glob("*.json")):
        place.keep(f"log/{path.name}", path.read_text())
