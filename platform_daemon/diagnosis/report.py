"""The diagnosis as JSON: the fixed form, and what else may be of use."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .diagnose import Diagnosis, Named
from .missing_torque import MissingTorque
from .search import Tried
from .significance import chance


def as_json(found: Diagnosis) -> dict[str, Any]:
    """The fixed form; unused keys are None."""
    before, after = found.before.total, found.after.total
    names = dict.fromkeys([*found.sigma_before, *found.sigma_after])
    return {
        "verdict": found.verdict,
        "effects": [_effect(n) for n in found.named],
        "held_out": {
            "nrmse_before": before.nrmse,
            "nrmse_after": after.nrmse,
            "chi2_per_dof_before": before.chi2_per_dof,
            "chi2_per_dof_after": after.chi2_per_dof,
            "n_shots": len(found.final.started),
        },
        "parameters_before": {n: {"value": m.value, "std": m.std} for n, m in found.parameters_before.items()},
        "parameters_after": {n: {"value": m.value, "std": m.std} for n, m in found.parameters_after.items()},
        "n50_d30": {
            n: {"before_sigma": found.sigma_before.get(n), "after_sigma": found.sigma_after.get(n)} for n in names
        },
        "integrity": [{"id": f.id, "where": f.where} for f in found.integrity],
        "missing_torque": None if found.torque is None else _torque(found.torque),
        "next_measurements": [
            {"what": p.measurement.what, "separates": list(p.separates), "expected_sigma": p.expected_sigma}
            for p in found.next_measurements
        ],
        "seconds": found.seconds,
        "model": found.model.name,
        "scatter": {n: m.scatter for n, m in found.parameters_after.items()},
        "ranking": [_tried(t) for t in found.found.tried[:40]],
        "left_over": {"gain": found.found.residues.excess, "p_value": found.found.residues.p_value},
        "notes": list(found.notes),
    }


def _effect(named: Named) -> dict[str, Any]:
    c = named.candidate
    return {
        "id": c.effect.id,
        "strength": {"value": named.strength, "std": named.std, "unit": c.effect.unit},
        "detail": _detail(named),
        "p_value": chance(named.log_p),
        "held_out_gain": named.held_out_gain,
        "indistinguishable_from": [
            i for i in dict.fromkeys(r.candidate.effect.id for r in named.alike) if i != c.effect.id
        ],
        "log10_p_value": named.log_p / math.log(10.0),
        "source": c.effect.source,
    }


def _detail(named: Named) -> dict[str, Any]:
    d, c = named.candidate.detail, named.candidate
    out: dict[str, Any] = {
        "axis": d.axis, "frequency_hz": d.frequency_hz, "tau_s": d.tau_s,
        "sample": d.sample, "from": d.start, "to": d.end,
    }  # fmt: skip
    if c.hidden and c.term is not None:
        out |= {q.name: v for q, v in zip(c.term.coefficients[1:], c.hidden, strict=True)}
    return out


def _tried(tried: Tried) -> dict[str, Any]:
    c = tried.candidates[0]
    return {
        "id": c.effect.id,
        "axis": c.detail.axis,
        "frequency_hz": c.detail.frequency_hz,
        "tau_s": c.detail.tau_s,
        "gain": tried.gain,
        "p_value": chance(tried.log_p),
        "sign_allowed": tried.allowed,
    }


def _torque(torque: MissingTorque) -> dict[str, Any]:
    """NaN, where the motion never was, as None."""

    def rows(values: np.ndarray) -> list[list[float | None]]:
        return [[None if math.isnan(v) else v for v in row] for row in values.tolist()]

    return {
        "phi": torque.phi.tolist(),
        "phi_dot": torque.phi_dot.tolist(),
        "value": rows(torque.value),
        "std": rows(torque.std),
        "gain": torque.gain,
    }
