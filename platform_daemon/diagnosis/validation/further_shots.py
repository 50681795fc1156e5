"""Shots of a long series that were not searched: what is found must hold for them too."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor
from dataclasses import dataclass
from itertools import islice

import numpy as np

from platform_daemon.estimation import LostTrajectoryError

from ..regression.hypothesis import Hypothesis
from ..regression.joint_fit import JointFit
from ..regression.own_fit import own_fit
from ..shots.initial_fits import initial_fits
from ..shots.shot import DiagnosisShot

_AT_ONCE = 2  # shots in memory


@dataclass(frozen=True)
class FurtherShots:
    """How the strengths that were found do on shots that had no part in finding them.

    Attributes:
        count: shots that could be fitted. failed: names of those that could not.
        before, after: mean chi^2 per degree of freedom of the declared model, and with the effects held at their
            strengths; the shots' own parameters are fitted in both.
        worst: name of the shot that is left with most, and its value.
    """

    count: int
    failed: tuple[str, ...]
    before: float
    after: float
    worst: tuple[str, float]

    @property
    def note(self) -> str:
        """For the reader."""
        failed = f"; {len(self.failed)} cannot be fitted: {', '.join(self.failed[:3])}" if self.failed else ""
        if not self.count:
            return f"none of the shots that were not searched can be fitted{failed}"
        return (
            f"{self.count} shots that were not searched, each with its own fit: chi2/dof {self.before:.4g} with the "
            f"declared model, {self.after:.4g} with what was found; {self.worst[1]:.4g} at worst "
            f"({self.worst[0]}){failed}"
        )


def further_shots(
    final: JointFit, shots: Iterable[Callable[[], DiagnosisShot | None]], pool: Executor, tell: Callable[[int], None]
) -> FurtherShots | None:
    """Fit shots a few at a time, so that any number of them needs the memory of a few; None if there are none.

    shots: each read when it is called for, None where it cannot be used. tell: called with the number that is done.
    """
    scores: list[tuple[str, float, float]] = []
    failed: list[str] = []

    def one(load: Callable[[], DiagnosisShot | None]) -> tuple[str, float, float] | str | None:
        shot = load()
        return None if shot is None else _scored(final, shot)

    done = 0
    for some in _batches(iter(shots)):
        for result in pool.map(one, some):
            if isinstance(result, str):
                failed.append(result)
            elif result is not None:
                scores.append(result)
        done += len(some)
        tell(done)
    if not scores:
        return FurtherShots(0, tuple(failed), np.nan, np.nan, ("", np.nan)) if failed else None
    worst = max(scores, key=lambda s: s[2])
    before, after = (float(np.mean([s[k] for s in scores])) for k in (1, 2))
    return FurtherShots(len(scores), tuple(failed), before, after, (worst[0], worst[2]))


def _batches(shots: Iterator[Callable[[], DiagnosisShot | None]]) -> Iterator[list[Callable[[], DiagnosisShot | None]]]:
    while some := list(islice(shots, _AT_ONCE)):
        yield some


def _scored(final: JointFit, shot: DiagnosisShot) -> tuple[str, float, float] | str:
    """(name, chi^2/dof before, after); its name alone if it cannot be fitted."""
    plain = Hypothesis(final.hypothesis.model)
    started, _ = initial_fits([shot], plain.model, None)
    if not started:
        return shot.name
    try:
        pairs = ((plain, np.zeros(0)), (final.hypothesis, final.strengths))
        before, after = (own_fit(started[0], h, strengths)[0].chi2 / started[0].dof for h, strengths in pairs)
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return shot.name
    return shot.name, before, after
