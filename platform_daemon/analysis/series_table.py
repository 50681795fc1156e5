"""The fits of a series as the store keeps them: numbers in columns, NaN where there is none."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from platform_daemon import __version__
from platform_daemon.estimation import FitResult
from platform_daemon.schemas import names_in_order
from platform_daemon.store import FitTable


def fit_table(name: str, variant: str, fits: list[FitResult | str]) -> FitTable:
    """On-line fits of a series; a text stands for a frame without a fit and says why."""
    good = {row: f for row, f in enumerate(fits) if isinstance(f, FitResult) and f.verdict == "good"}
    names = tuple(names_in_order({name for f in good.values() for name in f.parameters}))
    values = np.full((2, len(fits), len(names)), np.nan)  # estimates and their standard deviations
    covariance = np.full((len(fits), len(names), len(names)), np.nan)
    for row, fit in good.items():
        for name_of, estimate in fit.parameters.items():
            values[:, row, names.index(name_of)] = estimate.value, np.nan if estimate.std is None else estimate.std
        free = [names.index(n) for n in fit.covariance_names]
        covariance[row][np.ix_(free, free)] = fit.covariance

    def column(pick: Callable[[FitResult], float | None]) -> NDArray[np.float64]:
        return np.array([pick(good[row]) if row in good else None for row in range(len(fits))], dtype=float)

    return FitTable(
        name=name,
        parameters=names,
        values=values[0],
        std=values[1],
        covariance=covariance,
        r2=column(lambda fit: fit.r2),
        nrmse=column(lambda fit: fit.nrmse),
        chi2_per_dof=column(lambda fit: fit.chi2_per_dof),
        window_s=column(lambda fit: fit.window_s),
        verdict=tuple("refused" if isinstance(f, str) else f.verdict for f in fits),
        reason=tuple(f if isinstance(f, str) else f.reason or "" for f in fits),
        variant=variant,
        software_version=__version__,
    )
