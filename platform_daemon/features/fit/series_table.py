"""The fits of a series as the store keeps them: numbers in columns, NaN where there is none."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from platform_daemon import __version__
from platform_daemon.core.recordings.header import FitTable
from platform_daemon.core.schemas.fits import FrameFit
from platform_daemon.core.schemas.parameters import names_in_order


def fit_table(name: str, variant: str, fits: Sequence[FrameFit]) -> FitTable:
    """The fits of all frames of a series, in order; a refused or blank one has its reason and no numbers."""
    good = {row: fit for row, fit in enumerate(fits) if fit.good}
    names = tuple(names_in_order({name for fit in good.values() for name in fit.parameters}))
    values = np.full((2, len(fits), len(names)), np.nan)  # estimates and their standard deviations
    covariance = np.full((len(fits), len(names), len(names)), np.nan)
    for row, fit in good.items():
        for name_of, estimate in fit.parameters.items():
            values[:, row, names.index(name_of)] = estimate.value, np.nan if estimate.std is None else estimate.std
        if fit.covariance is not None:
            free = [names.index(n) for n in fit.covariance.parameters]
            covariance[row][np.ix_(free, free)] = fit.covariance.matrix

    def column(pick: Callable[[FrameFit], float | None]) -> NDArray[np.float64]:
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
        verdict=tuple(fit.verdict for fit in fits),
        reason=tuple(fit.reason or "" for fit in fits),
        variant=variant,
        software_version=__version__,
    )
