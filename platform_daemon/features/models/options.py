"""Adopted and declared models by what the command line names."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from platform_daemon.core.command_line.options import models_folder

if TYPE_CHECKING:
    from .library import Library
    from .resolve import ModelChoice


def library(folder: Path | None) -> Library:
    """The adopted models in a folder; default: where `serve` keeps them."""
    from .library import Library

    return Library(models_folder(folder))


def variant_named(text: str | None, folder: Path | None) -> ModelChoice | None:
    """A declared or adopted model; None: what a file says.  Raises InputError."""
    from .resolve import resolve

    return resolve(text, library(folder))
