"""What every route needs: the engine and the folders; handed in once by `app.py`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from fastapi import Depends, Request

from platform_daemon.analysis import Library
from platform_daemon.engine import Engine


@dataclass(frozen=True)
class Context:
    """Engine, folders of recordings, fit results and diagnoses, adopted models, folder of calibrations, and what has
    warmed up."""

    engine: Engine
    recordings: Path
    fits: Path
    diagnoses: Path
    models: Library
    calibrations: Path
    warm: dict[str, bool]


async def _context(request: Request) -> Context:
    context: Context = request.app.state.context
    return context


Shared = Annotated[Context, Depends(_context)]
