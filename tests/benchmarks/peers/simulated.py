"""Twenty shots of the simulated platform, dm/dt, each with one hidden torque or none, drawn by seed."""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.rotation import rotation_from_rodrigues
from tests.benchmarks.peers.datasets import TRAIN, Record, Task, split_in_time, write_dmdt
from tests.kit.undeclared_shots import shots_with

SEED = 2026
SECONDS = {"thread": 2.0, "jewel": 1.0}  # a jewel rests after little more
SIGMA = (15.0, 1000.0)  # strengths: evenly drawn in their logarithm between these multiples of the numbers below
NOTHING = "nothing"
# Standard deviation with which one shot (thread 2 s, jewel 1.6 s) shows the effect beside the declared parameters, as
# `visible` of tests/campaigns/diagnosis_study.py found it; kept as numbers so that the shots never change.
VISIBLE = {
    "thread": {
        "coulomb_friction": 0.078, "hertz_friction": 0.077, "quadratic_drag": 6.6e-7,
        "angle_dependent_damping": 2.3e-3, "restoring_anharmonicity": 8.0e-5,
    },
    "jewel": {
        "coulomb_friction": 1.4, "quadratic_drag": 2.6e-7, "angle_dependent_damping": 2.8e-4,
        "restoring_anharmonicity": 1.8e-5,
    },
}  # fmt: skip
DECLARED = {"thread": ("viscous_damping",), "jewel": ("viscous_damping", "hertz_friction")}


def drawn(k: int) -> tuple[str, str, float]:
    """Variant, effect and strength of shot k."""
    rng = np.random.default_rng([SEED, k])
    variant = "thread" if k % 2 == 0 else "jewel"
    names = (*VISIBLE[variant], NOTHING)
    name = names[int(rng.integers(len(names)))]
    sigma = math.exp(rng.uniform(math.log(SIGMA[0]), math.log(SIGMA[1])))
    return variant, name, 0.0 if name == NOTHING else sigma * VISIBLE[variant][name]


def simulated(k: int) -> Task:
    """Shot k with its split; its orientation and moment, for the peers, by the product's fit of the training part."""
    variant, name, strength = drawn(k)
    effects = [] if name == NOTHING else [{"id": name, "strength": strength}]
    (shot,), _ = shots_with(variant, effects, count=1, seed=SEED + k, rx_s=SECONDS[variant])
    record = shot.record
    samples = record.samples[:, record.valid_from : record.valid_to]
    time_s = np.arange(samples.shape[1]) / record.sampling_rate_hz
    bare = Record(f"s{k:02d}", time_s, samples, "dmdt")
    rotation, moment = _pose(bare.first(int(TRAIN * time_s.size)), variant)
    known = Record(bare.name, time_s, samples, "dmdt", rotation, moment)
    truth = () if name == NOTHING else (name,)
    return split_in_time(
        bare.name, known, variant=variant, declared=DECLARED[variant], truth=truth, strengths=(strength,) * len(truth)
    )


def _pose(record: Record, variant: str) -> tuple[Array, float]:
    """R and m_r as `platform-daemon fit` finds them."""
    with tempfile.TemporaryDirectory() as folder:
        file, out = Path(folder, "shot.mmr.h5"), Path(folder, "fit.json")
        write_dmdt(record, file, variant)
        command = [sys.executable, "-m", "platform_daemon", "fit", str(file), "--json", str(out)]
        subprocess.run(command, capture_output=True, check=False)
        found = json.loads(out.read_text(encoding="utf-8"))["frames"][0]["parameters"]
    rodrigues = np.array([found[f"rodrigues_{axis}"]["value"] for axis in "xyz"])
    return np.asarray(rotation_from_rodrigues(rodrigues)), float(found["m_r_am2"]["value"])
