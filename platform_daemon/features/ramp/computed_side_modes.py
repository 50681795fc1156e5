"""Evaluation of the z channel of a ramp's shots, by the task executor of the engine."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from drivers.errors import InputError
from platform_daemon.core.jobs.run_task import run_task_with_retry
from platform_daemon.core.jobs.workers.task_executor import TaskExecutor
from platform_daemon.features.fit.online import NamedModel, checked_model

if TYPE_CHECKING:
    from .predicted import PredictedThreshold
    from .recorded import RecordedSideModes
    from .z_residual import ZResidual


@dataclass(frozen=True)
class Learn:
    """The noise of blank shots.  A task of the task executor."""

    blank: Sequence[Path]

    def __call__(self, tell: Callable[[float, str], None]) -> RecordedSideModes:
        """Raises RecordingError."""
        from .recorded import RecordedSideModes

        made = RecordedSideModes()
        made.learn(self.blank)
        return made


@dataclass(frozen=True)
class LookAt:
    """Side modes of shots, compared with that noise.  A task of the task executor."""

    known: RecordedSideModes
    shots: Sequence[Path]

    def __call__(self, tell: Callable[[float, str], None]) -> list[ZResidual]:
        """Raises RecordingError."""
        return self.known.of(self.shots)


@dataclass(frozen=True)
class Predict:
    """The threshold by a model, from a shot of the ramp.  A task of the task executor."""

    known: RecordedSideModes
    model: NamedModel
    shot: Path
    main_hz: float | None
    lowest_t: float
    highest_t: float

    def __call__(self, tell: Callable[[float, str], None]) -> PredictedThreshold:
        """Raises RecordingError."""
        return self.known.predicted(self.model, self.shot, self.main_hz, self.lowest_t, self.highest_t)


class ComputedSideModes:
    """See SideModes."""

    def __init__(self, executor: TaskExecutor) -> None:
        self._executor = executor
        self._known: RecordedSideModes | None = None

    def learn(self, blank: Sequence[Path]) -> None:
        """See SideModes."""
        self._known = run_task_with_retry(self._executor, "procedure", Learn(tuple(blank)))

    def of(self, shots: Sequence[Path]) -> list[ZResidual]:
        """See SideModes.  Raises ValueError before `learn`."""
        return run_task_with_retry(self._executor, "procedure", LookAt(self._noise, tuple(shots)))

    def predicted(
        self, model: NamedModel, shot: Path, main_hz: float | None, lowest_t: float, highest_t: float
    ) -> PredictedThreshold:
        """See SideModes.  Raises ValueError before `learn`."""
        task = Predict(self._noise, model, shot, main_hz, lowest_t, highest_t)
        return run_task_with_retry(self._executor, "procedure", task)

    @property
    def _noise(self) -> RecordedSideModes:
        if self._known is None:
            raise ValueError("the noise is not known yet")
        return self._known


def model_with_error(label: str, models: Path | None, variant: str) -> NamedModel:
    """An adopted model with a manufacturing error, of a resonator with this variant.  Raises InputError."""
    found = checked_model(label, models)
    if not found.of_rotor:
        raise InputError(
            f"{found.label} holds no manufacturing error",
            where="predicted_by",
            why="only such an error predicts side modes",
            remedy="name a model that was adopted from a diagnosis with one (platform-daemon models)",
        )
    model = found.choice()
    assert not isinstance(model, str)
    if not model.base.startswith(variant):
        raise InputError(
            f"{found.label} was adopted from a {model.base}",
            where="predicted_by",
            why=f"the resonator is a {variant}",
            remedy="name a model of this resonator",
        )
    return found
