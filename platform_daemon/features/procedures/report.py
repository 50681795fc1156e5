"""Procedures for the terminal: what one would be, and what each of its steps has brought."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from platform_daemon.core.reporting.numbers import number
from platform_daemon.core.reporting.tables import Column, tables_text
from platform_daemon.core.schemas.parameters import definition_of
from platform_daemon.core.schemas.text import counted
from platform_daemon.core.schemas.value_sources import ValueSource, value_sources_text

from .schema import PlannedStep, ProcedureResult, ProcedureSummary, StepReport, SweptValue

_SHOWN = ("f_nat_hz", "m_r_am2", "lambda_per_s", "tf_over_i_rad_per_s2", "phi_max_rad")


def plan_text(plan: ProcedureSummary) -> str:
    """Every step with its values, then shots, duration, disk and warnings."""
    steps = ("step", [str(step.step) for step in plan.steps])
    columns = [
        *_values([step.values for step in plan.steps]),
        ("shots", [str(step.shots) for step in plan.steps]),
        ("duration / s", [f"{step.duration_s:.4g}" for step in plan.steps]),
    ]
    made = f"{counted(len(plan.steps), 'step')}, {counted(plan.shots, 'shot')}"
    total = f"{made}, {plan.duration_s:.4g} s, {plan.disk_bytes / 1e6:.3g} MB"
    rule = [] if plan.stop_when is None else [f"ends early when {plan.stop_when}"]
    notes = [*rule, *(f"warning: {text}" for text in plan.warnings)]
    return "\n".join([tables_text(plan.resonator, steps, columns), *_sources(plan.value_sources), total, *notes])


def steps_text(result: ProcedureResult, plan: ProcedureSummary) -> str:
    """A row per step: values, medians of the fits, shots, and why a step cannot be used."""
    steps = ("step", [str(step.step) for step in result.steps])
    names = [name for name in _SHOWN if any(name in step.results for step in result.steps)]
    remarks = [_remark(step) for step in result.steps]
    columns = [
        *_values([step.values for step in result.steps]),
        *((definition_of(name).heading, [_median(step, name) for step in result.steps]) for name in names),
        ("fitted", [f"{step.fitted} of {len(step.frames)}" for step in result.steps]),
    ]
    said = [f"step {step.step}: {text}" for step, text in zip(result.steps, remarks, strict=True) if text]
    sources = _sources(result.steps[-1].value_sources)
    return "\n".join([tables_text(plan.resonator, steps, columns), *said, *sources])


def _sources(sources: tuple[ValueSource, ...] | None) -> list[str]:
    return [] if not sources else ["values of the last step:", value_sources_text(sources)]


def step_rows(steps: Sequence[StepReport | PlannedStep]) -> list[dict[str, Any]]:
    """For a CSV: a row per step, with a column for each key that differs between the steps."""
    return [
        {"step": step.step, "values": {each.key: each.value for each in step.values}}
        | step.model_dump(exclude={"step", "values"})
        for step in steps
    ]


def _values(steps: list[tuple[SweptValue, ...]]) -> list[Column]:
    """A column per key."""
    keys = dict.fromkeys(value.key for values in steps for value in values)
    rows = [{value.key: _shown(value.value) for value in values} for values in steps]
    return [(key, [row.get(key, "") for row in rows]) for key in keys]


def _shown(value: float | str | tuple[float, ...]) -> str:
    if isinstance(value, tuple):
        return ",".join(f"{x:g}" for x in value)
    return value if isinstance(value, str) else f"{value:g}"


def _median(step: StepReport, name: str) -> str:
    found = step.results.get(name)
    if found is None:
        return "-"
    return number(found.median, found.std, definition_of(name).display_factor)


def _remark(step: StepReport) -> str:
    parts = (
        "cut short" if not step.complete else "",
        f"{step.refused} shots were refused" if step.refused else "",
        f"refused: {step.reason}" if step.reason else "",
    )
    return ", ".join(part for part in parts if part)
