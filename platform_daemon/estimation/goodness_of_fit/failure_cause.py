"""Why no fit got through: another variant would, the receiver compresses, there are two resonators, much is left.

Or the contact was lost, which only a model without the contact can show.
"""

from __future__ import annotations

import math
from dataclasses import replace

from platform_daemon.estimation.least_squares.problem import FitProblem, Minimum
from platform_daemon.estimation.physics.models import THREAD, RingDownModel, alternatives_of
from platform_daemon.estimation.prepared_record import PreparedRecord
from platform_daemon.estimation.refusal import Refusal, RefusedError
from platform_daemon.estimation.screening.angle_motion import refuse_undying
from platform_daemon.estimation.solve import find_minimum, find_minimum_coarsely
from platform_daemon.estimation.thresholds import THRESHOLDS

from .lack_of_fit import power_in_words, refuse_failed
from .residual import Residual
from .verdict import residual_findings, residual_left

LIMITS = THRESHOLDS.goodness_of_fit

_TROUBLE = (
    Refusal.NO_CONVERGENCE,
    Refusal.TOO_SHORT,
    Refusal.AMPLITUDE_BELOW_FLOOR,
    Refusal.MODEL_DOES_NOT_EXPLAIN,
    Refusal.OUT_OF_RANGE,
    Refusal.TWO_RESONATORS,
)


def refuse_lost_contact(prepared: PreparedRecord, model: RingDownModel, refused: RefusedError) -> None:
    """Refuse a swing beyond the angle where the model's torques hold, if a fit was refused for what that leads to.

    The second harmonic of so wide a swing exceeds the first, and is taken for it: half the frequency is tried as well.
    """
    limit = model.largest_angle_rad
    if refused.code not in _TROUBLE or limit == math.pi or prepared.record.quantity == "angle":
        return
    for frequency_hz in (prepared.frequency_hz, 0.5 * prepared.frequency_hz):
        reached = _first_amplitude_rad(prepared, frequency_hz)
        if reached is not None and reached > LIMITS.beyond_contact_ratio * limit:
            seen = f"{model.name}: the deflection reaches about {math.degrees(reached):.0f} deg"
            raise RefusedError(Refusal.CONTACT_LOST, seen) from refused


def _first_amplitude_rad(prepared: PreparedRecord, frequency_hz: float) -> float | None:
    """Amplitude of the first few periods by a model that holds at all angles; None if it does not describe them."""
    last = prepared.chosen.first + round(LIMITS.contact_periods / frequency_hz * prepared.record.sampling_rate_hz)
    chosen = replace(prepared.chosen, last=min(last, prepared.chosen.last))
    beginning = replace(prepared, chosen=chosen, frequency_hz=frequency_hz, fixed={})
    try:
        coarse = find_minimum_coarsely(beginning, THREAD)
    except RefusedError:
        return None
    if coarse is None or coarse[1].normal.chi2 > LIMITS.coarse_chi2_per_dof * beginning.degrees(coarse[0]):
        return None
    return abs(coarse[1].state.dynamics.amplitude)


def refuse_by_cause(prepared: PreparedRecord, model: RingDownModel) -> None:
    """Refuse a record in which no start led to a minimum, by what is seen instead; returns if nothing is.

    Raises:
        RefusedError: with the cause.
    """
    _refuse_by_alternatives(prepared, model)
    if prepared.record.quantity == "angle":
        refuse_undying(prepared.record, prepared.frequency_hz)
        return
    coarse = find_minimum_coarsely(prepared, model)
    if coarse is not None:
        problem, best = coarse
        _refuse_by_residual(prepared, problem, best, residual_left(prepared, problem, best))


def _refuse_by_alternatives(prepared: PreparedRecord, model: RingDownModel) -> None:
    """Another declared model goes through the record."""
    for other in alternatives_of(model, prepared.record.quantity):
        try:
            problem, best = find_minimum(prepared, other)
        except RefusedError:
            continue
        chi2 = best.normal.chi2 / prepared.degrees(problem)
        if chi2 < LIMITS.alternative_chi2_per_dof:
            seen = f"{model.name} finds no minimum, while {other.name} reaches chi2/dof = {chi2:.4g}"
            raise RefusedError(Refusal.MODEL_DOES_NOT_EXPLAIN, seen)


def _refuse_by_residual(prepared: PreparedRecord, problem: FitProblem, best: Minimum, residual: Residual) -> None:
    """What a coarse fit leaves over has a shape, or is simply large."""
    found = residual_findings(prepared, problem, best, residual)
    refuse_failed(residual, found, prepared.frequency_hz)
    if residual.coloured and residual.unexplained > LIMITS.failed_misfit_share:
        seen = f"{problem.model.name}: {power_in_words(residual.unexplained)} is left over"
        raise RefusedError(Refusal.MODEL_DOES_NOT_EXPLAIN, seen)
