"""Uncertainty budgets as REST, files and the command line have them."""

from __future__ import annotations

from typing import Literal

from pydantic import ConfigDict

from platform_daemon.core.schemas.base import Absent, Schema, example
from platform_daemon.core.schemas.fits import Covariance


class BudgetLine(Schema):
    """What one input contributes."""

    name: str
    """Of the input, in words."""
    value: float
    """Its estimate, SI; of relative ones 1."""
    u: float
    """Standard uncertainty, in the unit of the value."""
    type: Literal["A", "B"]
    """A: evaluated from repeated observations; B: from anything else."""
    distribution: str
    """normal, rectangular, triangular or arcsine."""
    dof: float | None
    """Degrees of freedom of u; null: infinitely many."""
    sensitivity: float
    """Change of the quantity per change of the input, in the quotient of their units."""
    contribution: float
    """|sensitivity| u, in the unit of the quantity."""
    source: str
    """Where it is known from."""


class InputCorrelation(Schema):
    """Two inputs that err together."""

    between: tuple[str, str]
    """Names of both."""
    r: float
    """Correlation coefficient, 1."""


class UndeclaredInfluence(Schema):
    """What the budget does not contain."""

    name: str
    """Of the influence, with the size of it that counts as a unit."""
    would_add_per_unit: float | None
    """Standard uncertainty of the quantity for each such unit, in its unit; null: not known."""


class MonteCarloCheck(Schema):
    """The budget against draws of all inputs through the linear model (JCGM 101:2008)."""

    trials: int
    """Draws."""
    value: float
    """Their mean, in the unit of the quantity."""
    u: float
    """Their standard deviation, in the unit of the quantity."""
    low: float
    """Low end of the interval that holds the coverage, with equal tails, in the unit of the quantity."""
    high: float
    """Its high end."""
    tolerance: float
    """Numerical tolerance of one significant digit of u, in the unit of the quantity (7.9.2)."""
    law_of_propagation_holds: bool
    """Both ends of value ± U are within the tolerance of those of the draws (8.1)."""
    conclusive: bool
    """There are draws enough to tell."""


class DirectionReport(Schema):
    """How well the orientation of the rotor is known."""

    covariance_rad2: tuple[tuple[float, ...], ...]
    """Covariance of a small rotation about the world axes x, y, z, rad^2, (3, 3)."""
    cone_rad: float
    """Half angle of the cone that contains a direction fixed to the rotor, at the coverage, rad."""


class OffCentreReport(Schema):
    """Whether the rotor stands off the centre of the coils, by what a fit leaves over."""

    seen: bool
    """It is off centre by more than chance."""
    probability: float
    """Chance that noise and what is declared of gains and orthogonality make as much."""
    distance_m: float | None
    """Least distance from the centre, at 95 %, m: of the nearest place that explains what is seen; null: nothing is
    seen, or no place does."""


class BudgetReport(Schema):
    """The uncertainty budget of one quantity (JCGM 100:2008)."""

    model_config = ConfigDict(json_schema_extra=example("budget_report"))

    quantity: str
    """Public name of the parameter, which holds its SI unit."""
    value: float
    """Estimate: of a shot, or the mean of a series."""
    u: float
    """Combined standard uncertainty of what is declared."""
    dof: float | None
    """Effective degrees of freedom; null: infinitely many."""
    k: float
    """Coverage factor."""
    U: float
    """Expanded uncertainty, k u."""
    coverage: float
    """Probability with which value ± U covers the quantity."""
    inputs: tuple[BudgetLine, ...]
    """The inputs, the largest contribution first."""
    correlations: tuple[InputCorrelation, ...]
    """Of inputs, those that are not 0."""
    not_declared: tuple[UndeclaredInfluence, ...]
    """Influences that nobody has declared."""
    temperature: Absent[str] = None
    """What a change of the temperature that was measured over the shots may have changed, while nobody has declared how
    the quantity follows it; missing: it is declared, or nothing was measured."""
    monte_carlo: Absent[MonteCarloCheck] = None
    """The check by draws; missing: it was not asked for."""
    covariance: Absent[Covariance] = None
    """Of this and of all other parameters of the result, all declared influences included; missing: `covariance` of all
    budgets says it."""
    direction: Absent[DirectionReport] = None
    """Of the orientation; missing: the result has none, or `direction` of all budgets says it."""
    off_centre: Absent[OffCentreReport] = None
    """Of the one shot, or of that in the middle of the series; missing: coil_radius_m is not declared, or `off_centre`
    of all budgets says it."""


class BudgetsReport(Schema):
    """The budgets of all parameters of a result."""

    file: str
    """Recording."""
    frames: tuple[int, ...]
    """Frames that the result is made of, from 0."""
    temperature_c: float | None
    """Their mean temperature, to which the values belong, degrees Celsius; null: not measured."""
    temperature_change_k: float | None
    """Highest minus lowest temperature of the frames, K; null: not measured."""
    budgets: tuple[BudgetReport, ...]
    """By parameter."""
    covariance: Covariance
    """Of the parameters, all declared influences included."""
    direction: DirectionReport | None
    """Of the orientation; null: the result has none."""
    off_centre: Absent[OffCentreReport] = None
    """Of the one shot, or of that in the middle of the series; missing: coil_radius_m is not declared."""
