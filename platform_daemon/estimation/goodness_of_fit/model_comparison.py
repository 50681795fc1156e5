"""Does another declared model explain a record better, and are the numbers of the fitted one wrong for it?

A record with a small undeclared effect must pass, since diagnosis starts from it: a little friction in addition to the
viscous loss of a thread does not make it a jewel. A rival with more parameters takes such effects up, and so needs to
move losses by more; one with as many does not.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from platform_daemon.estimation.least_squares.public_parameters import POOR_CHI2
from platform_daemon.estimation.parameters import Estimate
from platform_daemon.estimation.refusal import Refusal, RefusedError
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.goodness_of_fit


@dataclass(frozen=True, kw_only=True)
class ModelSummary:
    """What a model makes of a record.

    Attributes:
        name: of the model.
        chi2_per_dof: chi^2 over degrees of freedom.
        excess: chi^2 that exceeds the noise in the residual's spectrum, over degrees of freedom.
        size: number of free parameters.
        losses: names of its losses.
        parameters: estimates by public name.
        widening: by how much what it leaves of an angle weighs more than its noise.
    """

    name: str
    chi2_per_dof: float
    excess: float
    size: int
    losses: tuple[str, ...]
    parameters: Mapping[str, Estimate]
    widening: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Another declared model explains a record better.

    Attributes:
        seen: by how much.
        decisive: the numbers of the first are wrong then, or it has no loss for a decay: the other one is right.
        complete: it leaves hardly more than noise.
    """

    seen: str
    decisive: bool
    complete: bool


def compare_models(model: ModelSummary, other: ModelSummary, dof: int) -> Comparison | None:
    """What speaks against a model; None if the other one does not explain the record significantly better.

    One with as many parameters need not be better to cast doubt on numbers: it is enough that it is not worse.
    """
    gain = model.chi2_per_dof - other.chi2_per_dof
    least = LIMITS.alternative_chi2 / dof * max(1.0, other.chi2_per_dof, other.widening)
    if gain < LIMITS.alternative_part * model.excess or gain < -least or _feeds(model, other):
        return None
    complete = other.chi2_per_dof < POOR_CHI2
    moved = _moved(model, other) if complete else ()
    if gain < least:
        doubtful = bool(moved) and other.size <= model.size
        return Comparison(seen=_seen(model, other, moved), decisive=False, complete=complete) if doubtful else None
    wrong = not model.losses or bool(moved) or _shrinks(model, other)
    return Comparison(
        seen=_seen(model, other, moved),
        decisive=wrong and gain > LIMITS.alternative_most * model.excess,
        complete=complete,
    )


def _seen(model: ModelSummary, other: ModelSummary, moved: Sequence[str]) -> str:
    """Both in a line, with the number that differs."""
    seen = f"{model.name}: chi2/dof = {model.chi2_per_dof:.4g}, while {other.name} reaches {other.chi2_per_dof:.4g}"
    values = (f"{name} = {other.parameters[name].value:.6g}, not {model.parameters[name].value:.6g}" for name in moved)
    return ", with ".join([seen, *values][:2])


def _feeds(model: ModelSummary, other: ModelSummary) -> bool:
    """The other one needs a source of energy, which no variant of that name is."""
    own = [other.parameters[name] for name in other.losses if name not in model.losses]
    return any(loss.value < -LIMITS.source_sigma * (loss.std or 0.0) for loss in own)


def _shrinks(model: ModelSummary, other: ModelSummary) -> bool:
    """The other one takes most of a loss over."""
    pairs = [(model.parameters[name], other.parameters[name]) for name in model.losses if name in other.losses]
    return any(abs(theirs.value) < LIMITS.loss_share * abs(ours.value) for ours, theirs in pairs)


def _moved(model: ModelSummary, other: ModelSummary) -> tuple[str, ...]:
    """Names of the numbers of both that are significantly wrong in the first, by more than a number may be."""
    # psi and the pose are labels that hang on these.
    alike = ("f_nat_hz", "m_r_am2", "phi_max_rad", *model.losses)
    shared = [name for name in alike if name in model.parameters and name in other.parameters]
    return tuple(name for name in shared if _is_wrong(name, model, other))


def _is_wrong(name: str, model: ModelSummary, other: ModelSummary) -> bool:
    ours, theirs = model.parameters[name], other.parameters[name]
    if ours.std is None or theirs.std is None:
        return False
    most = LIMITS.frequency_share if name == "f_nat_hz" else LIMITS.number_share
    if name in model.losses and other.size > model.size:
        most = LIMITS.loss_share
    difference = abs(ours.value - theirs.value)
    sd = math.hypot(ours.std * math.sqrt(max(1.0, model.chi2_per_dof)), theirs.std)
    return difference > most * abs(theirs.value) and difference > LIMITS.number_sigma * sd


def refuse_decided(comparisons: Sequence[Comparison]) -> None:
    """Refuse a model if one of these is decisive."""
    for comparison in comparisons:
        if comparison.decisive:
            raise RefusedError(Refusal.MODEL_DOES_NOT_EXPLAIN, comparison.seen)
