"""Why no fit got through: another variant would, the receiver compresses, there are two resonators, much is left."""

from __future__ import annotations

from ..least_squares.growing import Fitted, Problem
from ..models import RingDownModel, rivals_of
from ..refusal import Refusal, RefusedError
from ..solving import solve, solve_coarsely
from ..task import Task
from .misfit import in_words, refuse_failed
from .residual import Residual
from .verdict import findings, residual_left

_EXPLAINED = 1.5  # chi^2 over degrees of freedom
_LEFT = 1e-3  # of the signal's power


def refuse_by_cause(task: Task, model: RingDownModel) -> None:
    """Refuse a record in which no start led to a minimum, by what is seen instead; returns if nothing is.

    Raises:
        RefusedError: with the cause.
    """
    _refuse_by_rivals(task, model)
    if task.record.quantity == "angle":
        return
    coarse = solve_coarsely(task, model)
    if coarse is not None:
        _refuse_by_residual(task, *coarse, residual_left(task, *coarse))


def _refuse_by_rivals(task: Task, model: RingDownModel) -> None:
    """Another declared model goes through the record."""
    for other in rivals_of(model, task.record.quantity):
        try:
            problem, best = solve(task, other)
        except RefusedError:
            continue
        chi2 = best.normal.chi2 / task.degrees(problem)
        if chi2 < _EXPLAINED:
            seen = f"{model.name} finds no minimum, while {other.name} reaches chi2/dof = {chi2:.4g}"
            raise RefusedError(Refusal.MODEL_DOES_NOT_EXPLAIN, seen)


def _refuse_by_residual(task: Task, problem: Problem, best: Fitted, residual: Residual) -> None:
    """What a coarse fit leaves over has a shape, or is simply large."""
    found = findings(task, problem, best, residual)
    refuse_failed(residual, found, task.frequency_hz)
    if residual.coloured and residual.unexplained > _LEFT:
        seen = f"{problem.model.name}: {in_words(residual.unexplained)} is left over"
        raise RefusedError(Refusal.MODEL_DOES_NOT_EXPLAIN, seen)
