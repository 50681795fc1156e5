"""How long what is left of a job takes."""

from __future__ import annotations

from collections.abc import Sequence


def left_s(planned: Sequence[float], before: float, done: float, total: float, worked_s: float) -> float | None:
    """By the pace so far, which without a plan must be there (else None), and else counts from the beginning as
    planned: what was made counts against one unit as long as all are on average.

    planned: s for each unit; before: units that were made before `worked_s` began; done, total: units.
    """
    made = _plan_s(planned, done) - _plan_s(planned, before)
    rest = max(0.0, _plan_s(planned, total) - _plan_s(planned, done))
    if not planned:
        return worked_s * rest / made if made > 0 else None
    mean_s = _plan_s(planned, total) / max(total, 1e-9)
    return rest * (worked_s + mean_s) / (made + mean_s)


def _plan_s(planned: Sequence[float], units: float) -> float:
    """What so many units take by the plan, s; 1 s each without one."""
    if not planned:
        return units
    whole = min(int(units), len(planned))
    part_s = (units - whole) * planned[whole] if whole < len(planned) else 0.0
    beyond_s = max(0.0, units - len(planned)) * sum(planned) / len(planned)
    return sum(planned[:whole]) + part_s + beyond_s
