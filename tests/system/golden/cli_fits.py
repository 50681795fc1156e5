"""Command line: fits, windows and harmonics of stored recordings."""

from __future__ import annotations

import shutil

import h5py
import numpy as np

from tests.system.golden.workplace import Workplace

JEWEL, THREAD = "example_jewel.mmr.h5", "example_thread.mmr.h5"
SWING = "r2_rotary_pendulum_run1.h5"


def _inputs(place: Workplace) -> None:
    """The examples, one without its calibration, one with a frame that cannot be fitted, and no recording at all."""
    place.take(JEWEL, THREAD, f"measured/{SWING}", "measured/r1_single_pendulum_55s.h5")
    shutil.copy(place.folder / JEWEL, place.folder / "volts.h5")
    with h5py.File(place.folder / "volts.h5", "r+") as file:
        del file["calibration"]
    shutil.copy(place.folder / JEWEL, place.folder / "flawed.h5")
    with h5py.File(place.folder / "flawed.h5", "r+") as file:
        file["data"][1, 2, -100] = np.nan
    shutil.copy(place.folder / JEWEL, place.folder / "quiet.h5")
    with h5py.File(place.folder / "quiet.h5", "r+") as file:
        file["data"][...] = 1e-5 * np.random.default_rng(1).standard_normal(file["data"].shape)
    (place.folder / "broken.h5").write_bytes(b"no hdf5")


def fits(place: Workplace) -> None:
    """`fit`: calibrated, volts, angles; whole batches; refused frames; every option."""
    _inputs(place)
    short = ("--window", "0.2")
    place.case("jewel", "fit", JEWEL, "--json", "jewel.json")
    place.case("thread", "fit", THREAD, "--json", "thread.json", "--window", "n50")
    place.case("volts", "fit", "volts.h5", "--json", "volts.json")
    place.case("angles", "fit", SWING, "--variant", "jewel_constant_friction", "--json", "angles.json")
    place.case("angles-refused", "fit", SWING, "--json", "angles-refused.json")
    place.case("angles-long", "fit", "r1_single_pendulum_55s.h5", "--json", "angles-long.json")
    place.case("refused", "fit", "quiet.h5", "--json", "refused.json")
    place.case("one-frame", "fit", JEWEL, *short, "--frames", "1", "--json", "one-frame.json")
    place.case("fixed", "fit", JEWEL, *short, "--fix", "lambda_per_s=0.2465", "--json", "fixed.json")
    place.case("hint", "fit", JEWEL, "--window", "0.05", "--hint", "lambda_per_s=0.2465", "--json", "hint.json")
    place.case("term", "fit", JEWEL, "--with-term", "quadratic_drag", "--json", "term.json")
    place.case("derived", "fit", JEWEL, "--derived", "--json", "derived.json")
    place.case("calibration", "fit", "volts.h5", *short, "--calibration", JEWEL, "--json", "calibration.json")
    place.case("other-variant", "fit", JEWEL, "--variant", "thread", "--json", "other-variant.json")
    for name, file in (("", JEWEL), ("-volts", "volts.h5"), ("-refused", "quiet.h5"), ("-flawed", "flawed.h5")):
        made = ("--json", f"characterise{name}.json", "--html", f"characterise{name}.html")
        place.case(f"characterise{name}", "characterise", "--from", file, *made)
    many = (JEWEL, "broken.h5", "flawed.h5", "volts.h5", "missing.h5")
    place.case("many", "fit", *many, *short, "--json", "many.json", "--jsonl", "many.jsonl")
    place.case("many-resumed", "fit", *many, *short, "--json", "resumed.json", "--jsonl", "many.jsonl", "--resume")
    pool = ("--processes", "2", "--json", "pool.json")
    place.case("processes", "fit", *_copies(place, 9), *short, *pool, ordered=False)


def _copies(place: Workplace, count: int) -> list[str]:
    """More frames than are fitted in one process."""
    names = [f"copy{k}.h5" for k in range(count)]
    for name in names:
        shutil.copy(place.folder / JEWEL, place.folder / name)
    return names


def windows(place: Workplace) -> None:
    """`slide`, `harmonics`, `predict`, `info`, `plot`, `config check`."""
    _inputs(place)
    place.case("slide-jewel", "slide", JEWEL, "--window", "0.12", "--json", "slide-jewel.json")
    place.case("slide-free", "slide", JEWEL, "--frame", "1", "--lambda", "free", "--step", "0.1", "--window", "0.2",
               "--json", "slide-free.json")  # fmt: skip
    place.case("slide-angles", "slide", "r1_single_pendulum_55s.h5", "--window", "10",
               "--json", "slide-angles.json", "--out", "slide.png")  # fmt: skip
    place.case("slide-refused", "slide", "quiet.h5", "--window", "0.1", "--json", "slide-refused.json")
    place.case("harmonics", "harmonics", JEWEL, "--json", "harmonics.json")
    place.case("harmonics-many", "harmonics", THREAD, "flawed.h5", "quiet.h5", "--json", "harmonics-many.json")
    place.case("harmonics-volts", "harmonics", "volts.h5", "--json", "harmonics-volts.json")
    for name in (JEWEL, THREAD, "volts.h5", SWING, "flawed.h5"):
        place.case(f"info-{name.partition('.')[0]}", "info", name, "--json", f"{name}.json")
    place.case("plot", "plot", JEWEL, "--frame", "1", "--png", "plot.png", "--window", "0.1")
    predictions(place)


def predictions(place: Workplace) -> None:
    """`predict` of both resonators, with terms and several windows."""
    place.case("predict-jewel", "predict", "--resonator", "jewel", "--json", "predict-jewel.json")
    place.case("predict-thread", "predict", "--resonator", "thread", "--window", "n50", "--window", "1.5",
               "--deflection-deg", "40", "--noise", "0.01,0.02,0.03", "--json", "predict-thread.json")  # fmt: skip
    place.case("predict-term", "predict", "--resonator", "jewel", "--with-term", "quadratic_drag",
               "--expect", "quadratic_drag_per_rad=1e-4", "--json", "predict-term.json")  # fmt: skip
