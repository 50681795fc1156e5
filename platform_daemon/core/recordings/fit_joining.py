"""The tables of fits of several steps as those of one recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .header import FitTable

NOT_FITTED = "this step was not fitted under this window and model"
PlacedTable = tuple[int, FitTable]
"""The number of the first frame of a table, from 0, and the table."""


def joined_fits(tables: Sequence[PlacedTable], frames: int) -> list[FitTable]:
    """One table per window and model, each with a row for every frame; the rows of other steps are refused."""
    groups: dict[tuple[str, str], list[PlacedTable]] = {}
    for first, table in tables:
        groups.setdefault((table.name, table.variant), []).append((first, table))
    names = [name for name, _ in groups]
    return [
        _joined(name if names.count(name) == 1 else _name_of_both(name, variant), parts, frames)
        for (name, variant), parts in groups.items()
    ]


def _name_of_both(window: str, variant: str) -> str:
    return f"{window}-{''.join(c if c.isalnum() or c in '_-.' else '-' for c in variant)}"


def _joined(name: str, parts: Sequence[PlacedTable], frames: int) -> FitTable:
    parameters = tuple(dict.fromkeys(p for _, table in parts for p in table.parameters))
    k = len(parameters)
    values, std = np.full((frames, k), np.nan), np.full((frames, k), np.nan)
    covariance = np.full((frames, k, k), np.nan)
    columns: dict[str, Any] = {c: np.full(frames, np.nan) for c in ("r2", "nrmse", "chi2_per_dof", "window_s")}
    verdict, reason = ["refused"] * frames, [NOT_FITTED] * frames
    for first, table in parts:
        rows = slice(first, first + len(table.verdict))
        at = [parameters.index(p) for p in table.parameters]
        values[rows, at], std[rows, at] = table.values, table.std
        _fill(covariance[rows], at, table.covariance)
        for column, all_rows in columns.items():
            all_rows[rows] = getattr(table, column)
        verdict[rows], reason[rows] = table.verdict, table.reason
    return replace(
        parts[0][1],
        name=name,
        parameters=parameters,
        values=values,
        std=std,
        covariance=covariance,
        verdict=tuple(verdict),
        reason=tuple(reason),
        **columns,
    )


def _fill(rows: NDArray[np.float64], at: list[int], blocks: NDArray[np.float64]) -> None:
    for row, block in zip(rows, blocks, strict=True):
        row[np.ix_(at, at)] = block
