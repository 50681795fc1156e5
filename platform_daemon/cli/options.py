"""Options and small parts that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from drivers.calibration import ReceiveCalibration
    from platform_daemon.analysis import Library, ModelChoice
    from platform_daemon.engine import Catalogue

PlatformOption = Annotated[str, typer.Option("--platform", help="Platform file, or the name of one that ships.")]
SetOption = Annotated[list[str] | None, typer.Option("--set", help="Override KEY=VALUE of the platform file.")]
BeyondOption = Annotated[
    bool, typer.Option("--beyond-side-modes", help="Above the highest field that a ramp has kept for this resonator.")
]
EndpointsOption = Annotated[
    Path | None,
    typer.Option("--endpoints", help="Addresses for ${...} in the platform file, as `emulate` writes them."),
]
JsonOption = Annotated[Path | None, typer.Option("--json", help="Write the result as JSON.")]
HtmlOption = Annotated[Path | None, typer.Option("--html", help="Write the report with pictures as one page.")]
ForceOption = Annotated[bool, typer.Option("--force", help="Overwrite files that exist.")]
DryRunOption = Annotated[bool, typer.Option("--dry-run", help="Check everything and show the plan; nothing moves.")]
FramesOption = Annotated[str | None, typer.Option("--frames", help="Frames from 0, as 0,2,5-9; default: all.")]
WindowOption = Annotated[str, typer.Option("--window", help="Evaluation window: n50, d30 or seconds.")]
VariantOption = Annotated[
    str | None,
    typer.Option("--variant", help="thread, jewel, another declared or an adopted model; default: the file's."),
]
ModelsOption = Annotated[
    Path | None,
    typer.Option("--models", envvar="PLATFORM_DAEMON_MODELS", help="Folder of adopted models; default: data/models."),
]
PresetsOption = Annotated[
    Path | None,
    typer.Option(
        "--presets",
        envvar="PLATFORM_DAEMON_PRESETS",
        help="Folder of the presets that tune has found; default: data/presets.",
    ),
]
TermOption = Annotated[
    list[str] | None, typer.Option("--with-term", help="A further torque term, as quadratic_drag; may be repeated.")
]
FixOption = Annotated[list[str] | None, typer.Option("--fix", help="Hold NAME=VALUE fixed.")]
CalibrationOption = Annotated[Path | None, typer.Option("--calibration", help="Use the calibration in this file.")]


def library(folder: Path | None) -> Library:
    """The adopted models in a folder; default: where `serve` keeps them."""
    from platform_daemon.analysis import Library

    return Library(folder or Path("data", "models"))


def catalogue(presets: Path | None) -> Catalogue:
    """What ships, with the presets that tune has kept in a folder; default: where `serve` keeps them."""
    from platform_daemon.engine import Catalogue, TunedPresets

    return Catalogue(tuned=TunedPresets(presets or Path("data", "presets")))


def calibration_in(file: Path | None) -> tuple[ReceiveCalibration, str] | None:
    """A calibration in the place of the files' own, and where it came from.  Raises RecordingError."""
    from platform_daemon.store import read_calibration

    return None if file is None else (read_calibration(file), str(file))


def variant_named(text: str | None, folder: Path | None) -> ModelChoice | None:
    """A declared or adopted model; None: what a file says.  Raises InputError."""
    from platform_daemon.analysis import resolve

    return resolve(text, library(folder))
