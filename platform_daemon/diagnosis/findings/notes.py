"""Further remarks for the reader of a diagnosis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.effects.kick import KICK
from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.regression.parameters import Mean
from platform_daemon.diagnosis.selection.sign_constraints import negative_effects, negative_losses
from platform_daemon.diagnosis.selection.stepwise import Selection
from platform_daemon.diagnosis.shots.initial_fits import UnfittedShot
from platform_daemon.diagnosis.thresholds import THRESHOLDS

from .accepted_effects import AcceptedEffect

_LIMITS = THRESHOLDS.findings


def undecided(exact: Mapping[str, Mean], spanned: Mapping[str, Mean]) -> list[str]:
    """Which parameters depend on the choice among look-alikes."""
    names = [n for n, m in spanned.items() if m.std > _LIMITS.noted_growth * exact[n].std]
    if not names:
        return []
    return [f"errors of {', '.join(names)} span what the look-alikes of the named effects would make of them"]


def two_in_place_notes(named: Sequence[AcceptedEffect]) -> list[str]:
    """Where two torques fit better than the one that is named."""
    return [
        f"{r.candidate.effect.id} and {r.second.effect.id} in the place of {n.candidate.effect.id} fit better, "
        f"by {-r.rise:.1f} of chi2: not enough to name two effects"
        for n in named
        for r in n.confounders
        if r.second is not None
    ]


def notes(
    found: Selection,
    final: JointFit,
    alike: Sequence[Candidate],
    refused: Sequence[UnfittedShot],
    dropped: Sequence[Candidate],
) -> tuple[str, ...]:
    """All remarks, in the order of the report.

    alike: candidates that could take the place of an accepted one; refused: shots that could not be fitted; dropped:
    candidates that do not predict held-out data better.
    """
    lines = [f"{r.shot.name} was left out: {r.reason}" for r in refused]
    if len(final.prepared) == 1:
        lines.append("one shot only: held out is the last 30 % of its window, predicted from the first 70 %")
    lines += dict.fromkeys(c.effect.absorbed for c in (*final.hypothesis.effects, *alike) if c.effect.absorbed)
    lines += [f"{c.effect.id} gains in the fit but not on held-out data, and was not accepted" for c in dropped]
    if found.forbidden:
        names = " and ".join(c.effect.id for c in found.forbidden)
        lines.append(f"the best fit is with {names} of a sign that physics does not allow")
    if final.hypothesis.held_at_zero:
        names = " and ".join(final.hypothesis.model.coefficients[k].name for k in final.hypothesis.held_at_zero)
        lines.append(f"{names} is held at 0: beside these effects the best fit has it negative, which physics forbids")
    for k in negative_losses(final):
        name = final.hypothesis.model.coefficients[k].name
        lines.append(
            f"{name} comes out negative, which physics forbids: it stands for a loss that falls with the swing"
        )
    lines += [
        f"{name} comes out negative: with what else is lost, the loss as a whole falls with the swing"
        for name in negative_effects(final)
    ]
    if found.others:
        told = found.others[: _LIMITS.told_sets]
        sets = "; ".join(" + ".join(c.effect.id for c in other.hypothesis.effects) for other in told)
        more = f"; and {len(found.others) - len(told)} more" if len(told) < len(found.others) else ""
        lines.append(f"what is left is no noise, so that sets which leave little more are as likely: {sets}{more}")
    if final.chi2_per_dof > _LIMITS.noted_chi2_per_dof:
        lines.append(f"chi2/dof stays at {final.chi2_per_dof:.3g}: errors and chances are widened accordingly")
        lines += [
            f"a kick is followed to first order only: cut the record at sample {c.detail.sample}, diagnose both parts"
            for c in final.hypothesis.effects
            if c.effect is KICK
        ]
    return tuple(lines)
