"""The ends of shots, predicted from their beginnings by a rotor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.diagnosis.shots.thread_pool import beside_each_other
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.rigid_rotor.rotor import LostRotorError, NoRestError
from platform_daemon.estimation.rotor_fit.fit import RotorFit, Stage, fit_rotor, quiet_values
from platform_daemon.estimation.rotor_fit.parameters import FreeParameter, free_parameters
from platform_daemon.estimation.rotor_fit.shot import linearised


@dataclass(frozen=True, kw_only=True)
class HeldOutRotor:
    """Of each shot: chi^2 of the part that was predicted, with the errors of the prediction, its degrees of freedom,
    squares of the residual and of the data there."""

    chi2: tuple[float, ...]
    dof: tuple[float, ...]
    squares: tuple[float, ...]
    energy: tuple[float, ...]

    @property
    def chi2_per_dof(self) -> float:
        """Of all shots."""
        return sum(self.chi2) / sum(self.dof)

    @property
    def is_good(self) -> bool:
        """What the prediction leaves is about noise and its own error."""
        return self.chi2_per_dof < THRESHOLDS.rigid_body.poor_prediction_chi2_per_dof

    @property
    def nrmse(self) -> float:
        """Rms of the error over that of the data."""
        return math.sqrt(sum(self.squares) / sum(self.energy))


def held_out_ends(fits: Sequence[RotorFit], pool: Executor) -> HeldOutRotor:
    """At most 70 % of the first shot predicts its end; of the others the longest window of at most 30 %, if there is
    one, with the common values of the first.

    fits: of each shot alone, with stages.  Raises RotorFitError.
    """
    first = [None, *[fits[0]] * (len(fits) - 1)]
    rows = beside_each_other(lambda row: _end(*row, pool), zip(fits, first, strict=True))
    chi2, dof, squares, energy = zip(*rows, strict=True)
    return HeldOutRotor(chi2=chi2, dof=dof, squares=squares, energy=energy)


def _end(fit: RotorFit, first: RotorFit | None, pool: Executor) -> tuple[float, float, float, float]:
    """chi^2, degrees of freedom, squares of the residual and of the data.

    r^T (1 + J C J^T)^-1 r with the Jacobian J of the end and the covariance C of what predicts it is
    r^T r - g^T (C^-1 + J^T J)^-1 g with g = J^T r.  Raises RotorFitError.
    """
    shot, limits = fit.shots[0], THRESHOLDS.regression
    share = limits.split_share if first is None else limits.own_share
    whole_s = shot.samples.shape[1] / shot.rate_hz
    early = [s for s in fit.stages if s.window_s <= share * whole_s]
    own = Stage(fit.window_s, fit.values, fit.total_chi2)
    stage = (early or list(fit.stages) or [own])[-1]
    values, n = stage.values[0], shot.count(stage.window_s)
    free = free_parameters(shot.geometry, [fit.defect] if fit.defect else [], shot.start)
    if n >= shot.samples.shape[1]:  # so short that no window came before the whole
        n = shot.count(share * whole_s)
        part = replace(shot, samples=shot.samples[:, :n], values=values)
        held = () if first is None else tuple(p.name for p in free if p.common)
        values = fit_rotor([part], fit.defect, pool, first_window_s=math.inf, held=held).values[0]
    data = shot.samples[:, n:]
    try:
        found = linearised(shot, quiet_values(shot, values), free, whole_s, pool)
        model, _ = shot.rotor(values).dm_dt(shot.samples.shape[1], shot.rate_hz)
    except (NoRestError, LostRotorError):
        squares = data - data.mean(axis=1, keepdims=True)
        white = float(np.sum((squares / shot.sd[:, None]) ** 2))
        return white, shot.noise_share * data.size, float(np.sum(squares**2)), float(np.sum(data**2))
    left = data - model[:, n:]
    left = left - left.mean(axis=1, keepdims=True)
    white = left / shot.sd[:, None]
    columns = found.columns.reshape(len(free), 3, -1).astype(np.float64)
    before, end = columns[:, :, :n], columns[:, :, n:]
    end = (end - end.mean(axis=2, keepdims=True)).reshape(len(free), -1)
    before = (before - before.mean(axis=2, keepdims=True)).reshape(len(free), -1)
    known = _information(before @ before.T, free, first)
    g = end @ white.ravel()
    chi2 = float(np.sum(white**2)) - float(g @ np.linalg.solve(known + end @ end.T, g))
    return chi2, shot.noise_share * white.size, float(np.sum(left**2)), float(np.sum(data**2))


def _information(seen: Array, free: Sequence[FreeParameter], first: RotorFit | None) -> Array:
    """C^-1 of the free parameters before the end is seen, (free, free).

    The first shot tells all of them; of another one the beginning tells what is its own, with what is common as the
    first shot has it.
    """
    if first is None:
        return seen + np.diag([0.0 if p.sd is None else p.sd**-2 for p in free])
    common = [k for k, p in enumerate(free) if p.common and p.name in first.places[0]]
    own = [k for k, p in enumerate(free) if not p.common]
    places = [first.places[0][free[k].name] for k in common]
    spread = first.covariance[np.ix_(places, places)]
    alone = seen[np.ix_(own, own)] + np.diag([0.0 if (sd := free[k].sd) is None else sd**-2 for k in own])
    follow = np.linalg.solve(alone, seen[np.ix_(own, common)])
    out = np.zeros_like(seen)
    # Of the block matrix C = [[S, -S F^T], [-F S, A^-1 + F S F^T]] the inverse is exact without inverting C.
    out[np.ix_(own, own)] = alone
    out[np.ix_(own, common)] = alone @ follow
    out[np.ix_(common, own)] = (alone @ follow).T
    out[np.ix_(common, common)] = np.linalg.inv(spread) + follow.T @ alone @ follow
    return out
