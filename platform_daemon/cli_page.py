"""The page of a diagnosis, where --html says."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from platform_daemon.files import write_whole

if TYPE_CHECKING:
    from platform_daemon.diagnosis import Diagnosis


def write_page(path: Path | None, found: Diagnosis, report: Mapping[str, Any]) -> None:
    """Write and print its name; without a path, nothing."""
    if path is not None:
        from platform_daemon.diagnosis_page import diagnosis_page

        write_whole(path, diagnosis_page(found, report))
        print(path)
