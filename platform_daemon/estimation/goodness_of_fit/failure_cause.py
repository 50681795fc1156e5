"""Why no fit got through: another variant would, the receiver compresses, there are two resonators, much is left.

Or the contact was lost, which only a model without the contact can tell.
"""

from __future__ import annotations

import math
from dataclasses import replace

from ..least_squares.problem import FitProblem, Minimum
from ..physics.models import THREAD, RingDownModel, alternatives_of
from ..refusal import Refusal, RefusedError
from ..screening.angle_motion import refuse_undying
from ..solve import find_minimum, find_minimum_coarsely
from ..task import Task
from .lack_of_fit import in_words, refuse_failed
from .residual import Residual
from .thresholds import LIMITS
from .verdict import residual_findings, residual_left

_FIRST_PERIODS = 7.0  # at a wide swing the frequency changes fast
_TROUBLE = (
    Refusal.NO_CONVERGENCE,
    Refusal.TOO_SHORT,
    Refusal.AMPLITUDE_BELOW_FLOOR,
    Refusal.MODEL_DOES_NOT_EXPLAIN,
    Refusal.OUT_OF_RANGE,
    Refusal.TWO_RESONATORS,
)


def refuse_lost_contact(task: Task, model: RingDownModel, refused: RefusedError) -> None:
    """Refuse a swing beyond the angle where the model's torques hold, if a fit was refused for what that leads to.

    The second harmonic of so wide a swing exceeds the first, and is taken for it: half the frequency is tried as well.
    """
    limit = model.largest_angle_rad
    if refused.code not in _TROUBLE or limit == math.pi or task.record.quantity == "angle":
        return
    for frequency_hz in (task.frequency_hz, 0.5 * task.frequency_hz):
        reached = _first_amplitude_rad(task, frequency_hz)
        if reached is not None and reached > LIMITS.beyond_contact_ratio * limit:
            seen = f"{model.name}: the deflection reaches about {math.degrees(reached):.0f} deg"
            raise RefusedError(Refusal.CONTACT_LOST, seen) from refused


def _first_amplitude_rad(task: Task, frequency_hz: float) -> float | None:
    """Amplitude of the first few periods by a model that holds at all angles; None if it does not describe them."""
    last = task.chosen.first + round(_FIRST_PERIODS / frequency_hz * task.record.sampling_rate_hz)
    chosen = replace(task.chosen, last=min(last, task.chosen.last))
    beginning = replace(task, chosen=chosen, frequency_hz=frequency_hz, fixed={})
    try:
        coarse = find_minimum_coarsely(beginning, THREAD)
    except RefusedError:
        return None
    if coarse is None or coarse[1].normal.chi2 > LIMITS.coarse_chi2_per_dof * beginning.degrees(coarse[0]):
        return None
    return abs(coarse[1].state.dynamics.amplitude)


def refuse_by_cause(task: Task, model: RingDownModel) -> None:
    """Refuse a record in which no start led to a minimum, by what is seen instead; returns if nothing is.

    Raises:
        RefusedError: with the cause.
    """
    _refuse_by_alternatives(task, model)
    if task.record.quantity == "angle":
        refuse_undying(task.record, task.frequency_hz)
        return
    coarse = find_minimum_coarsely(task, model)
    if coarse is not None:
        _refuse_by_residual(task, *coarse, residual_left(task, *coarse))


def _refuse_by_alternatives(task: Task, model: RingDownModel) -> None:
    """Another declared model goes through the record."""
    for other in alternatives_of(model, task.record.quantity):
        try:
            problem, best = find_minimum(task, other)
        except RefusedError:
            continue
        chi2 = best.normal.chi2 / task.degrees(problem)
        if chi2 < LIMITS.alternative_chi2_per_dof:
            seen = f"{model.name} finds no minimum, while {other.name} reaches chi2/dof = {chi2:.4g}"
            raise RefusedError(Refusal.MODEL_DOES_NOT_EXPLAIN, seen)


def _refuse_by_residual(task: Task, problem: FitProblem, best: Minimum, residual: Residual) -> None:
    """What a coarse fit leaves over has a shape, or is simply large."""
    found = residual_findings(task, problem, best, residual)
    refuse_failed(residual, found, task.frequency_hz)
    if residual.coloured and residual.unexplained > LIMITS.failed_misfit_share:
        seen = f"{problem.model.name}: {in_words(residual.unexplained)} is left over"
        raise RefusedError(Refusal.MODEL_DOES_NOT_EXPLAIN, seen)
