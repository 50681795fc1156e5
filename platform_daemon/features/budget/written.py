"""Budgets as they are written: from the library's form to that of REST, files and the command line."""

from __future__ import annotations

import math

from platform_daemon.core.schemas.fits import Covariance
from platform_daemon.core.schemas.parameters import definition_of
from platform_daemon.uncertainty.budget import Budget
from platform_daemon.uncertainty.monte_carlo import MonteCarloResult, check_law_of_propagation

from .schema import (
    BudgetLine,
    BudgetReport,
    BudgetsReport,
    DirectionReport,
    InputCorrelation,
    MonteCarloCheck,
    OffCentreReport,
    UndeclaredInfluence,
)
from .work import Array, ResultBudgets


def budget_report(budget: Budget, drawn: MonteCarloResult | None = None, change_k: float | None = None) -> BudgetReport:
    """The budget as it is written; change_k: by how much the temperature changed over the shots, None: not measured."""
    return BudgetReport(
        quantity=budget.quantity,
        value=budget.value,
        u=budget.u,
        dof=None if math.isinf(budget.dof) else budget.dof,
        k=budget.k,
        U=budget.expanded,
        coverage=budget.coverage,
        inputs=tuple(
            BudgetLine(
                name=line.input.name,
                value=line.input.value,
                u=line.input.u,
                type=line.input.kind,
                distribution=line.input.distribution,
                dof=None if math.isinf(line.input.dof) else line.input.dof,
                sensitivity=line.sensitivity,
                contribution=line.contribution,
                source=line.input.source,
            )
            for line in budget.by_contribution()
        ),
        correlations=tuple(InputCorrelation(between=(one, other), r=r) for one, other, r in budget.correlations),
        not_declared=tuple(
            UndeclaredInfluence(
                name=each.name,
                would_add_per_unit=None if math.isnan(each.would_add_per_unit) else each.would_add_per_unit,
            )
            for each in budget.not_declared
        ),
        temperature=_undeclared_change(budget, change_k),
        monte_carlo=None if drawn is None else _check(budget, drawn),
    )


def _undeclared_change(budget: Budget, change_k: float | None) -> str | None:
    """Of the quantity, by a measured change of the temperature, while nobody has declared how it follows."""
    missing = [
        one for one in budget.not_declared if one.name.startswith("temperature") and "thermometer" not in one.name
    ]
    if not change_k or not missing or math.isnan(missing[0].would_add_per_unit):
        return None
    adds, unit = missing[0].would_add_per_unit * change_k, definition_of(budget.quantity).unit
    return (
        f"it changed by {change_k:.2g} K over the shots, and {budget.quantity} perhaps by {adds:.2g} {unit}, which is "
        "in the scatter; nobody has declared how it follows: write temperature_coefficient_per_k into [uncertainty] of "
        "the resonator's file"
    )


def _check(budget: Budget, drawn: MonteCarloResult) -> MonteCarloCheck:
    checked = check_law_of_propagation(budget, drawn)
    return MonteCarloCheck(
        trials=drawn.trials,
        value=drawn.value,
        u=drawn.u,
        low=drawn.low,
        high=drawn.high,
        tolerance=drawn.tolerance,
        law_of_propagation_holds=checked.holds,
        conclusive=checked.conclusive,
    )


def one_report(found: ResultBudgets, quantity: str, drawn: MonteCarloResult | None = None) -> BudgetReport:
    """The budget of one parameter of a result, with the covariance of all.  Raises InputError for a name of none."""
    more = {"covariance": _covariance(found), "direction": _direction(found), "off_centre": _off_centre(found)}
    return budget_report(found.of(quantity), drawn, found.temperature_change_k).model_copy(update=more)


def _covariance(found: ResultBudgets) -> Covariance:
    return Covariance(parameters=tuple(each.quantity for each in found.budgets), matrix=_rows(found.covariance))


def _direction(found: ResultBudgets) -> DirectionReport | None:
    if found.rotation is None or found.cone_rad is None:
        return None
    return DirectionReport(covariance_rad2=_rows(found.rotation), cone_rad=found.cone_rad)


def _off_centre(found: ResultBudgets) -> OffCentreReport | None:
    told = found.off_centre
    if told is None:
        return None
    return OffCentreReport(seen=told.seen, probability=told.probability, distance_m=told.distance_m)


def budgets_report(found: ResultBudgets, file: str) -> BudgetsReport:
    """All budgets of a result as they are written."""
    return BudgetsReport(
        file=file,
        frames=found.frames,
        temperature_c=found.temperature_c,
        temperature_change_k=found.temperature_change_k,
        budgets=tuple(budget_report(each, change_k=found.temperature_change_k) for each in found.budgets),
        covariance=_covariance(found),
        direction=_direction(found),
        off_centre=_off_centre(found),
    )


def _rows(matrix: Array) -> tuple[tuple[float, ...], ...]:
    return tuple(map(tuple, matrix.tolist()))
