"""Score tests: how much of an effect is visible beside the declared parameters, and how much of it is in the residual.

Declared parameters, each shot's own, are projected out by orthogonal factorisation (the Gram matrix would lose the last
digits, on which look-alikes such as torsion stiffness depend). What is left of all shots adds up to one small matrix.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr
from scipy.stats import chi2 as chi2_distribution

from platform_daemon.estimation.arrays import Array

from .look import Look

_RESOLVED = 1e-11  # part of a column's power that must survive the projection


@dataclass(frozen=True)
class Projected:
    """Columns of one shot after projection: information (q, q), gradient (q,), full power (q,), residual power, m."""

    information: Array
    gradient: Array
    power: Array
    chi2: float
    dof: int

    def __add__(self, other: Projected) -> Projected:
        """Both shots together, if their columns share their strengths."""
        return Projected(
            self.information + other.information,
            self.gradient + other.gradient,
            self.power + other.power,
            self.chi2 + other.chi2,
            self.dof + other.dof,
        )


def project(look: Look, columns: Array, keep: Array | None = None) -> Projected:
    """Project the declared parameters out of columns (q, channels m), in units of the noise.

    keep: bool (p,) which of the look's parameters are declared; None: all.
    """
    base = look.base if keep is None else look.base[keep]
    scale = np.linalg.norm(base, axis=1)
    q, _ = qr((base / np.where(scale > 0.0, scale, 1.0)[:, None]).T, mode="economic")
    rest = columns - (columns @ q) @ q.T
    rest -= (rest @ q) @ q.T
    residual = look.whitened - q @ (q.T @ look.whitened)
    return Projected(
        information=rest @ rest.T,
        gradient=rest @ residual,
        power=np.asarray(np.sum(columns**2, axis=1)),
        chi2=float(residual @ residual),
        dof=residual.size - q.shape[1],
    )


@dataclass(frozen=True)
class Score:
    """What a linear step in some columns would gain: strengths (q,), covariance (q, q), fall of chi^2."""

    strengths: Array
    covariance: Array
    gain: float

    @property
    def p_value(self) -> float:
        """Chance of such a gain if the strengths are zero, uncorrected."""
        return float(chi2_distribution.sf(self.gain, self.strengths.size))


def score(projected: Projected, which: list[int]) -> Score | None:
    """Score test of some columns together; None if nothing of them survives the projection."""
    visible = np.diag(projected.information)[which] > _RESOLVED * projected.power[which]
    if not np.all(visible):
        return None
    matrix = projected.information[np.ix_(which, which)]
    scale = 1.0 / np.sqrt(np.diag(matrix))
    scaled = matrix * np.outer(scale, scale)
    if np.linalg.cond(scaled) > 1e10:
        return None
    covariance = np.linalg.inv(scaled) * np.outer(scale, scale)
    strengths = covariance @ projected.gradient[which]
    return Score(strengths, covariance, float(projected.gradient[which] @ strengths))
