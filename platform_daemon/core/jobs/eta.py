"""Estimate of the remaining time of a job."""

from __future__ import annotations

from collections.abc import Sequence


def remaining_s(planned: Sequence[float], before: float, done: float, total: float, worked_s: float) -> float | None:
    """Remaining time of a job, s; None without a plan before the first unit is done.

    Without a plan it follows from the pace so far.  With a plan the planned time is scaled by the pace so far, in
    which one further average unit at the planned pace is included, so that the first units do not dominate.

    planned: s for each unit, may be empty; before: units that were done before `worked_s` began; done, total: units.
    """
    made = _plan_s(planned, done) - _plan_s(planned, before)
    rest = max(0.0, _plan_s(planned, total) - _plan_s(planned, done))
    if not planned:
        return worked_s * rest / made if made > 0 else None
    mean_s = _plan_s(planned, total) / max(total, 1e-9)
    return rest * (worked_s + mean_s) / (made + mean_s)


def _plan_s(planned: Sequence[float], units: float) -> float:
    """Planned time of the first `units` units, s; 1 s each without a plan."""
    if not planned:
        return units
    whole = min(int(units), len(planned))
    part_s = (units - whole) * planned[whole] if whole < len(planned) else 0.0
    beyond_s = max(0.0, units - len(planned)) * sum(planned) / len(planned)
    return sum(planned[:whole]) + part_s + beyond_s
