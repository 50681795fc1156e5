"""The effects are tested on shots of a long series that were not searched."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import cache
from itertools import islice

import numpy as np

from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.regression.per_shot_fit import per_shot_fit
from platform_daemon.diagnosis.shots.initial_fits import initial_fits, nearer_mirror_image
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError, MotionParameters

_LIMITS = THRESHOLDS.validation


@dataclass(frozen=True, kw_only=True)
class FurtherShots:
    """Goodness of fit of the found strengths on shots that were not used to find them.

    Attributes:
        count: shots that could be fitted. failed: names of those that could not.
        before, after: mean chi^2 per degree of freedom of the declared model, and with the effects held at their
            strengths; the shots' own parameters are fitted in both.
        worst: name and value of the shot with the largest chi^2 per degree of freedom after.
    """

    count: int
    failed: tuple[str, ...]
    before: float
    after: float
    worst: tuple[str, float]

    @property
    def note(self) -> str:
        """Sentence for the report."""
        failed = f"; {len(self.failed)} cannot be fitted: {', '.join(self.failed[:3])}" if self.failed else ""
        if not self.count:
            return f"none of the shots that were not searched can be fitted{failed}"
        return (
            f"{self.count} shots that were not searched, each with its own fit: chi2/dof {self.before:.4g} with the "
            f"declared model, {self.after:.4g} with what was found; {self.worst[1]:.4g} at worst "
            f"({self.worst[0]}){failed}"
        )


def further_shots(
    final: JointFit,
    shots: Iterable[Callable[[], DiagnosisShot | None]],
    pool: Executor,
    progress: Callable[[int], None],
    declared: RingDownModel,
) -> FurtherShots | None:
    """Fit further shots a few at a time to bound the memory; None if there are none.

    declared: the model before; that of the final fit has the torques of which every shot has its own strength too.
    shots: each is read by its call, which returns None if it cannot be used. progress: called with the number done.
    """
    scores: list[tuple[str, float, float]] = []
    failed: list[str] = []

    def one(load: Callable[[], DiagnosisShot | None]) -> tuple[str, float, float] | str | None:
        shot = load()
        return None if shot is None else _scored(final, shot, declared)

    done = 0
    for some in _batches(iter(shots)):
        for result in pool.map(one, some):
            if isinstance(result, str):
                failed.append(result)
            elif result is not None:
                scores.append(result)
        done += len(some)
        progress(done)
    if not scores:
        return (
            FurtherShots(count=0, failed=tuple(failed), before=np.nan, after=np.nan, worst=("", np.nan))
            if failed
            else None
        )
    worst = max(scores, key=lambda s: s[2])
    before, after = (float(np.mean([s[k] for s in scores])) for k in (1, 2))
    return FurtherShots(count=len(scores), failed=tuple(failed), before=before, after=after, worst=(worst[0], worst[2]))


def _batches(shots: Iterator[Callable[[], DiagnosisShot | None]]) -> Iterator[list[Callable[[], DiagnosisShot | None]]]:
    while some := list(islice(shots, _LIMITS.shots_in_memory)):
        yield some


def _scored(final: JointFit, shot: DiagnosisShot, declared: RingDownModel) -> tuple[str, float, float] | str:
    """(name, chi^2/dof before, after); its name alone if it cannot be fitted."""
    scores: list[float] = []
    fitted = cache(lambda model: initial_fits([shot], model, None)[0])
    for hypothesis, strengths in ((Hypothesis(declared), np.zeros(0)), (final.hypothesis, final.strengths)):
        prepared = fitted(hypothesis.model)
        if not prepared:
            return shot.name
        try:
            side = nearer_mirror_image(prepared[0].state, final.states[0], hypothesis.model)
            one = replace(prepared[0], state=side)
            near = _moved_alike(side, final) if strengths.size else None
            scores.append(per_shot_fit(one, hypothesis, strengths, near=near)[0].chi2 / one.dof)
        except (LostTrajectoryError, np.linalg.LinAlgError):
            return shot.name
    return shot.name, scores[0], scores[1]


def _moved_alike(state: FitState, final: JointFit) -> FitState | None:
    """The state of an initial fit, with its motion moved as the effects moved those of the searched shots (medians);
    None where that has other parameters."""
    pairs = [(shot.state.dynamics, end.dynamics) for shot, end in zip(final.prepared, final.states, strict=True)]
    if any(len(d.values) != len(state.dynamics.values) for pair in pairs for d in pair):
        return None
    steps = [
        (
            after.theta - before.theta,
            after.w - before.w,
            math.log(abs(after.amplitude / before.amplitude)),
            *np.subtract(after.values, before.values),
        )
        for before, after in pairs
    ]
    by_theta, by_w, by_amplitude, *by_values = np.median(steps, axis=0).tolist()
    d = state.dynamics
    return replace(
        state,
        dynamics=MotionParameters(
            w=d.w + by_w,
            theta=d.theta + by_theta,
            amplitude=d.amplitude * math.exp(by_amplitude),
            values=tuple(q + dq for q, dq in zip(d.values, by_values, strict=True)),
        ),
    )
