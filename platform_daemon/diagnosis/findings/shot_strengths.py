"""Strengths that differ from shot to shot: where no common ones explain several shots, each is fitted alone."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.regression.joint_fit import JointFit, fit_jointly
from platform_daemon.diagnosis.shots.thread_pool import InlineExecutor
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

_LIMITS = THRESHOLDS.findings


@dataclass(frozen=True, kw_only=True)
class ShotStrengths:
    """Strengths of every shot alone.

    Attributes:
        effects: the common effects of the set, of one strength each. shots: names.
        values: (shots, effects), as published.
        together, alone: chi^2 with common strengths and with strengths of each shot's own.
    """

    effects: tuple[Candidate, ...]
    shots: tuple[str, ...]
    values: Array
    together: float
    alone: float

    @property
    def differ(self) -> bool:
        """Strengths of each shot's own explain most of what common ones leave."""
        return self.alone < _LIMITS.own_strength_share * self.together

    @property
    def notes(self) -> list[str]:
        """A sentence for each effect, and which shot is the odd one."""
        lines = []
        for c, values in zip(self.effects, self.values.T, strict=True):
            each = ", ".join(f"{v:.4g}" for v in values)
            scatter = float(np.std(values, ddof=1))
            lines.append(
                f"{c.effect.id} differs from shot to shot: {each} {c.effect.unit}, that is "
                f"{float(np.mean(values)):.4g} with a scatter of {scatter:.2g}{self._odd(values)}"
            )
        return [*lines, f"with strengths of its own each shot leaves {self.alone / self.together:.2g} of that chi2"]

    def _odd(self, values: Array) -> str:
        """The one shot that is much further from the others than these are from each other."""
        if values.size < 3:
            return ""
        spans = [float(np.ptp(np.delete(values, k))) for k in range(values.size)]
        k = int(np.argmin(spans))
        apart = float(np.min(np.abs(np.delete(values, k) - values[k])))
        return f"; {self.shots[k]} is the odd one" if apart > _LIMITS.odd_shot_ratio * spans[k] else ""


def strengths_by_shot(at: JointFit, pool: Executor) -> ShotStrengths | None:
    """Of a set of effects; None of one shot, of noise, or where no effect is common."""
    if len(at.prepared) == 1 or at.chi2_per_dof < THRESHOLDS.regression.noise_chi2_per_dof:
        return None
    slices = zip(at.hypothesis.common, at.hypothesis.slices, strict=True)
    single = [(c, where.start) for c, where in slices if c.size == 1]
    if not single:
        return None

    def alone(k: int) -> JointFit | None:
        try:
            return fit_jointly([at.prepared[k]], at.hypothesis, InlineExecutor(), [at.states[k]], at.strengths)
        except (LostTrajectoryError, np.linalg.LinAlgError):
            return None

    fits = [f for f in pool.map(alone, range(len(at.prepared))) if f is not None]
    if len(fits) < len(at.prepared):
        return None
    return _of(at, fits, single)


def _of(at: JointFit, fits: Sequence[JointFit], single: Sequence[tuple[Candidate, int]]) -> ShotStrengths:
    rows = []
    for fit in fits:
        f_nat_hz = fit.states[0].dynamics.w / (2.0 * np.pi)
        rows.append([c.public(float(fit.strengths[k]), 0.0, f_nat_hz)[0] for c, k in single])
    return ShotStrengths(
        effects=tuple(c for c, _ in single),
        shots=tuple(s.shot.name for s in at.prepared),
        values=np.array(rows),
        together=at.chi2,
        alone=sum(f.chi2 for f in fits),
    )
