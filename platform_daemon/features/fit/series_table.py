"""The fits of a series as the store keeps them: numbers in columns, NaN where there is none; and back."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from platform_daemon import __version__
from platform_daemon.core.recordings.header import FitTable
from platform_daemon.core.recordings.recorded_fits import read_fit
from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.schemas.fits import Covariance, FrameFit, ParameterEstimate, unfitted
from platform_daemon.core.schemas.parameters import names_in_order

from .fit_request import FitRequest
from .measurement import Measurement, VoltageMeasurement


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
        correction=_corrections(fits),
    )


def _corrections(fits: Sequence[FrameFit]) -> str:
    """The tables that corrected fits were made with, each once, as a JSON list; "" where none was."""
    found = dict.fromkeys(to_json(fit.correction) for fit in fits if fit.correction is not None)
    return f"[{', '.join(found)}]" if found else ""


def recorded_fits(measurement: Measurement, ask: FitRequest) -> tuple[FrameFit, ...] | None:
    """The on-line fits that the recording keeps, in order, if they are what is asked for.

    None: a fit must be made, because there are none of this window and model, they are of another version of the
    software, the calibration is another one, or parameters are held.  Raises RecordingError for a damaged table.
    """
    if not isinstance(measurement, VoltageMeasurement) or measurement.calibration_file is not None:
        return None
    if ask.fixed or ask.hold_if_inseparable or str(ask.window) not in measurement.recording.fits:
        return None
    table = read_fit(measurement.recording, str(ask.window))
    if (table.variant, table.software_version) != (ask.label, __version__) or table.correction:
        return None  # a fit of the whole rotor tells more than one that was corrected on-line
    fits = tuple(_frame(table, row) for row in range(measurement.frames))
    return None if any(fit.good and fit.covariance is None for fit in fits) else fits


def _frame(table: FitTable, row: int) -> FrameFit:
    """A row as a report has it, without what the table does not hold."""
    if table.verdict[row] != "good":
        return unfitted(row, table.reason[row])
    held = [k for k, value in enumerate(table.values[row]) if np.isfinite(value)]
    free = [k for k in held if np.isfinite(table.std[row, k])]
    covariance = table.covariance[row][np.ix_(free, free)]
    matrix = tuple(map(tuple, covariance.tolist())) if np.isfinite(covariance).all() else None
    std = table.std[row].tolist()
    return unfitted(row, "").model_copy(
        update={
            "verdict": "good",
            "reason": None,
            "parameters": {
                table.parameters[k]: ParameterEstimate(
                    value=float(table.values[row, k]), std=std[k] if k in free else None
                )
                for k in held
            },
            "covariance": None
            if matrix is None
            else Covariance(parameters=tuple(table.parameters[k] for k in free), matrix=matrix),
            "window_s": float(table.window_s[row]),
            "chi2_per_dof": float(table.chi2_per_dof[row]),
        }
    )
