"""The steps of a procedure as a pandas table."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from platform_daemon.core.reporting.dataframes import pandas_module
from platform_daemon.features.procedures.schema import StepReport

if TYPE_CHECKING:
    import pandas as pd


def steps_table(steps: Iterable[StepReport]) -> pd.DataFrame:
    """One row for each step of a procedure: what it was made with, and median and standard deviation of its results.

    Raises InputError without pandas.
    """
    pandas = pandas_module()
    rows = []
    for step in steps:
        row: dict[str, Any] = {"step": step.step, "verdict": step.verdict, "reason": step.reason}
        row |= {each.key: each.value for each in step.values}
        for name, estimate in step.results.items():
            row[name] = estimate.median
            if estimate.std is not None:
                row[f"{name}_std"] = estimate.std
        rows.append(row)
    return pandas.DataFrame(rows).set_index("step") if rows else pandas.DataFrame()
