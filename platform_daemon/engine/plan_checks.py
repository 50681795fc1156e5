"""Can it be done at all?  What a schedule asks for is checked before it is kept, long before anything is due."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from platform_daemon import analysis
from platform_daemon.schemas import CalibrationRequest

from .computed import computed_surely
from .engine import Engine
from .work.calibration import calibration_work
from .work.calibration_bench import CalibrationWork

_BARE, _ITS_OWN = "undamped", "magnetic_restoring"  # a declared model that any term but its own can be added to


def plan_calibration(engine: Engine, request: CalibrationRequest, folder: Path) -> CalibrationWork:
    """Its checked work; nothing moves.  Raises ConfigError, InputError."""
    return calibration_work(engine.platform, request, engine.side, folder, engine.calibration_in_use.self_test)


def check_model(engine: Engine, label: str | None, terms: Sequence[str] = ()) -> None:
    """Is there such a declared or adopted model (None: whatever a recording says), are there such terms?

    Raises InputError, with the names there are.
    """
    folder = None if engine.models is None else engine.models.folder
    labels = [] if label is None else [label]
    if any(term != _ITS_OWN for term in terms):
        labels.append("+".join((_BARE, *(term for term in terms if term != _ITS_OWN))))
    for each in labels:
        computed_surely(engine.online, "planning", analysis.CheckModel(analysis.NamedModel(each, folder)))
