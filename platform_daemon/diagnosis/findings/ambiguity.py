"""An effect with what acts alike, and what further measurements would tell of the two."""

from __future__ import annotations

from concurrent.futures import Executor

from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.selection.confounders import gain_of

from .accepted_effects import AcceptedEffect
from .experiment_design import discrimination
from .next_measurements import Ambiguity


def ambiguity_of(named: AcceptedEffect, final: JointFit, pool: Executor) -> Ambiguity:
    """An effect with its look-alikes, and the discrimination that further measurements would bring."""
    effect = named.candidate
    # An effect with a hidden scale is represented by its likeliest value.
    others: dict[object, Candidate] = {}
    accepted = [t.term for t in final.hypothesis.torques]
    for c in (r.candidate for r in named.confounders):
        if c.effect is not effect.effect and (c.term is None or c.term not in accepted):
            others.setdefault((c.effect.id, c.detail) if c.term is None else c.term.name, c)
    alike = tuple(others.values()) or tuple(r.candidate for r in named.confounders if r.candidate.term is effect.term)

    def expected(key: str) -> list[float] | None:
        return discrimination(final, effect, alike, key, pool)

    return Ambiguity(effect=effect, confounders=alike, rise=named.rise, gain=gain_of(final, effect), expected=expected)
