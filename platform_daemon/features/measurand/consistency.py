"""Whether the numbers of a calibration can be those of one: a file may have been changed by hand."""

from __future__ import annotations

import numpy as np

from .schema import MeasurandCalibration

_NEGATIVE = -1e-6  # an eigenvalue of a correlation matrix that the digits of a file explain


def contradiction(made: MeasurandCalibration) -> str:
    """What is wrong with the numbers; "": nothing."""
    n = len(made.parameters)
    own = {"polynomial": made.degree + 1, "dipole": 2}.get(made.model)
    if own is not None and n != (wanted := own + (made.temperature_c is not None)):
        return f"its model has {wanted} parameters, and the file {n}"
    if made.temperature_c is not None and None in (made.temperature_from_c, made.temperature_to_c):
        return "it is corrected for a temperature, and does not say for which ones it holds"
    if any(len(row) != n for row in (made.covariance, *made.covariance)):
        return f"the covariance is not {n} by {n}"
    numbers = [*made.parameters.values(), made.centre, made.scale, made.valid_from, made.valid_to, made.scatter_hz]
    if not np.isfinite([*numbers, made.dof, *(each for row in made.covariance for each in row)]).all():
        return "a number is not finite"
    if not (made.scale > 0.0 and made.valid_to > made.valid_from and made.scatter_hz >= 0.0 and made.dof >= 1.0):
        return "scale, range, scatter or degrees of freedom are none"
    covariance = np.array(made.covariance)
    size = np.sqrt(np.maximum(covariance.diagonal(), 0.0))
    size[size == 0.0] = 1.0
    relative = covariance / np.outer(size, size)
    if not np.allclose(relative, relative.T) or np.linalg.eigvalsh(relative)[0] < _NEGATIVE:
        return "the covariance of its parameters is none"
    return ""
