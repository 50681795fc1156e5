"""The diagnosis as JSON: the fixed form, and what else may be of use."""

from __future__ import annotations

import math
from typing import Any

from .diagnose import Diagnosis
from .findings.accepted_effects import AcceptedEffect
from .findings.missing_torque import MissingTorque
from .selection.significance import chance
from .selection.stepwise import CandidateTest

_ANGLE_UNITS = {"A m^2/s": "rad"}  # of what stands beside the signal


def as_json(found: Diagnosis) -> dict[str, Any]:
    """The fixed form; unused keys are None, and so is what is not finite."""
    return dict(_finite(_report(found)))


def _finite(value: Any) -> Any:
    """With None in the place of numbers that JSON cannot hold."""
    if isinstance(value, dict):
        return {k: _finite(v) for k, v in value.items()}
    if isinstance(value, list):
        return [_finite(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _report(found: Diagnosis) -> dict[str, Any]:
    before, after = found.before.total, found.after.total
    names = dict.fromkeys([*found.sigma_before, *found.sigma_after])
    return {
        "verdict": found.verdict,
        "effects": [_effect(n, found.shots[0].record.quantity) for n in found.named],
        "held_out": {
            "nrmse_before": before.nrmse if before.dof else None,
            "nrmse_after": after.nrmse if after.dof else None,
            "chi2_per_dof_before": before.chi2_per_dof if before.dof else None,
            "chi2_per_dof_after": after.chi2_per_dof if after.dof else None,
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
        "left_over": {"gain": found.found.omnibus_test.excess, "p_value": found.found.omnibus_test.p_value},
        "notes": list(found.notes),
    }


def _effect(named: AcceptedEffect, quantity: str) -> dict[str, Any]:
    c = named.candidate
    unit = _ANGLE_UNITS.get(c.effect.unit, c.effect.unit) if quantity == "angle" else c.effect.unit
    return {
        "id": c.effect.id,
        "strength": {"value": named.strength, "std": named.std, "unit": unit},
        "detail": _detail(named),
        "p_value": chance(named.log_p),
        # Without the effect nothing could be predicted at all: no number for that.
        "held_out_gain": named.held_out_gain if math.isfinite(named.held_out_gain) else None,
        "indistinguishable_from": [
            i for i in dict.fromkeys(r.candidate.effect.id for r in named.confounders) if i != c.effect.id
        ],
        "log10_p_value": named.log_p / math.log(10.0),
        "source": c.effect.source,
    }


def _detail(named: AcceptedEffect) -> dict[str, Any]:
    d, c = named.candidate.detail, named.candidate
    out: dict[str, Any] = {
        "axis": d.axis, "frequency_hz": d.frequency_hz, "tau_s": d.tau_s,
        "sample": d.sample, "from": d.start, "to": d.end,
    }  # fmt: skip
    if c.hidden and c.term is not None:
        out |= {q.name: v for q, v in zip(c.term.coefficients[1:], c.hidden, strict=True)}
    return out


def _tried(tried: CandidateTest) -> dict[str, Any]:
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
    return {
        "phi": torque.phi.tolist(),
        "phi_dot": torque.phi_dot.tolist(),
        "value": torque.value.tolist(),
        "std": torque.std.tolist(),
        "gain": torque.gain,
    }
