"""The product's `diagnose`, run by its command with default settings, and the model that its JSON says."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from tests.benchmarks.peers.columns import COLUMNS, Model, Torque, model_of, smooth_sign
from tests.benchmarks.peers.datasets import Task, write_angles, write_dmdt
from tests.benchmarks.peers.sindy import overview

SETTINGS = (
    "`platform-daemon diagnose FILES --json FILE` on the training part written as files, no other option, in a "
    "process of its own (its start and the loading of compiled kernels are in the seconds)"
)
_DATA_ONLY = {"clock_gap"}
_TIME_BOX_S = 900.0


@dataclass(frozen=True)
class Said:
    """What the diagnosis says: its model, its names with their look-alikes, and what of it is not simulated here."""

    model: Model | None
    verdict: str
    named: tuple[str, ...] = ()
    alike: tuple[str, ...] = ()
    remark: str = ""


def diagnosed(task: Task) -> Said:
    """Of the training part."""
    with tempfile.TemporaryDirectory() as folder:
        files = [
            write_angles(r, Path(folder, f"{r.name}.h5"))
            if r.quantity == "angle"
            else write_dmdt(r, Path(folder, f"{r.name}.mmr.h5"), str(task.variant))
            for r in task.train
        ]
        json_file = Path(folder, "diagnosis.json")
        command = [sys.executable, "-m", "platform_daemon", "diagnose", *map(str, files), "--json", str(json_file)]
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, timeout=_TIME_BOX_S, env=dict(os.environ), check=False
            )
        except subprocess.TimeoutExpired:
            return Said(None, "none", remark=f"not done after {_TIME_BOX_S:.0f} s")
        if done.returncode != 0 or not json_file.exists():
            last = (done.stderr.strip().splitlines() or ["nothing said"])[-1].replace(folder, ".")
            return Said(None, "none", remark=f"exit {done.returncode}: {last[:160]}")
        report = json.loads(json_file.read_text(encoding="utf-8"))
    return said(report, task)


def said(report: Mapping[str, Any], task: Task) -> Said:
    """The model of a report. Without a named effect it is that of `before`."""
    named = report["effects"]
    stage = report["parameters_after"] if any(e["id"] not in _DATA_ONLY for e in named) else report["parameters_before"]
    parameters = {n: p["value"] for n, p in stage.items()}
    _, speed = overview(task)
    w = 2.0 * math.pi * parameters["f_nat_hz"]
    terms = {"sine": w**2, "viscous_damping": parameters.get("lambda_per_s", 0.0)}
    if "tf_over_i_rad_per_s2" in parameters:
        terms["hertz_friction"] = parameters["tf_over_i_rad_per_s2"]
    model, left_out = _with_effects(model_of(terms, speed), named, w, task)
    remark = f"not simulated: {', '.join(left_out)}" if left_out else ""
    return Said(
        model,
        report["verdict"],
        tuple(dict.fromkeys(e["id"] for e in named)),
        tuple(dict.fromkeys(i for e in named for i in e["indistinguishable_from"])),
        remark,
    )


def _with_effects(base: Model, named: list[Any], w: float, task: Task) -> tuple[Model, list[str]]:
    """The declared model with what was named; and names that a trajectory does not show."""
    terms, gaps, left_out, further = dict(base.terms), [], [], []
    for e in named:
        name, strength, detail = e["id"], e["strength"]["value"], e["detail"]
        if name in COLUMNS:
            terms[name] = terms.get(name, 0.0) + strength * _IN_COLUMNS.get(name, lambda w: 1.0)(w)
        elif name == "clock_gap" and len(task.train) == 1:
            time_s = task.train[0].time_s
            gaps.append((float(time_s[detail["sample"]]), strength * float(time_s[1] - time_s[0])))
        elif name in ("stribeck_friction", "frequency_drift"):
            further.append((name, strength, detail))
        else:
            left_out.append(name)
    plain = model_of(terms, base.speed)
    torques = [plain.torque, *(_FURTHER[name](strength, detail, terms, w, task) for name, strength, detail in further)]

    def torque(phi: float, v: float, t: float) -> float:
        return sum(one(phi, v, t) for one in torques)

    every = dict(terms) | {name: strength for name, strength, _ in further}
    return replace(plain, torque=torque if further else plain.torque, terms=every, gaps=tuple(gaps)), left_out


# From the unit of a report to that of a column.
_IN_COLUMNS = {
    "torsion_stiffness": lambda w: w**2,
    "restoring_anharmonicity": lambda w: w**2,
    "cubic_restoring": lambda w: -(w**2),
}


def _stribeck(strength: float, detail: Mapping[str, Any], terms: Mapping[str, float], w: float, task: Task) -> Torque:
    """Dry friction that falls with the speed: of its own size, or a share of the declared friction of a contact."""
    sign, own = smooth_sign(overview(task)[1]), detail.get("stribeck_coulomb_speed_rad_per_s")
    speed = own or detail.get("stribeck_speed_rad_per_s") or math.inf
    declared = terms.get("hertz_friction", 0.0)

    def torque(phi: float, v: float, t: float) -> float:
        dry = strength if own else strength * declared * max(math.cos(phi), 0.0) ** (4.0 / 3.0)
        return -sign(v) * dry * math.exp(-abs(v) / speed)

    return torque


def _drift(strength: float, detail: Mapping[str, Any], terms: Mapping[str, float], w: float, task: Task) -> Torque:
    """Linear in time, or settling."""
    tau_s, start_s = detail.get("tau_s"), float(np.min(task.scored.time_s))

    def torque(phi: float, v: float, t: float) -> float:
        since = t - start_s if tau_s is None else tau_s * -math.expm1(-(t - start_s) / tau_s)
        d = strength / (w / (2.0 * math.pi)) * since
        return -(w**2) * math.sin(phi) * d * (2.0 + d)

    return torque


_FURTHER = {"stribeck_friction": _stribeck, "frequency_drift": _drift}
