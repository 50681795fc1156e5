"""Options that several commands share, alone and in groups, and what these options name."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .output import must_not_exist

if TYPE_CHECKING:
    from drivers.calibration import ReceiveCalibration
    from platform_daemon.core.hardware.engine import Engine
    from platform_daemon.core.settings import PlatformFile

_ASSEMBLY = "platform_daemon.processes.assembly"  # by name: it puts the features together, and stands above them
PlatformOption = Annotated[str, typer.Option("--platform", help="Platform file, or the name of one that ships.")]
RealTimeOption = Annotated[
    bool, typer.Option("--real-time", help="Let simulated time pass as this computer's; default: as fast as it can.")
]
SetOption = Annotated[list[str] | None, typer.Option("--set", help="Override KEY=VALUE of the platform file.")]
BeyondOption = Annotated[
    bool, typer.Option("--beyond-side-modes", help="Above the highest field that a ramp has kept for this resonator.")
]
EndpointsOption = Annotated[
    Path | None,
    typer.Option("--endpoints", help="Addresses for ${...} in the platform file, as `emulate` writes them."),
]
JsonOption = Annotated[Path | None, typer.Option("--json", help="Write the result as JSON.")]
CsvOption = Annotated[Path | None, typer.Option("--csv", help="Write the table, columns named as in --json.")]
HtmlOption = Annotated[Path | None, typer.Option("--html", help="Write the report with pictures as one page.")]
ForceOption = Annotated[bool, typer.Option("--force", help="Overwrite files that exist.")]
DryRunOption = Annotated[bool, typer.Option("--dry-run", help="Check everything and show the plan; nothing moves.")]
FramesOption = Annotated[str | None, typer.Option("--frames", help="Frames from 0, as 0,2,5-9; default: all.")]
StepOption = Annotated[
    str | None,
    typer.Option("--step", help="Step of a procedure's recording: number or name, as series; default: the last one."),
]
StepOrAllOption = Annotated[
    str | None,
    typer.Option("--step", help="Step of a procedure's recording: number, name, or all; default: the last one."),
]
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
        help="Folder of the presets that tune has found; default: presets in --data.",
    ),
]
DataOption = Annotated[
    Path, typer.Option("--data", help="Data folder: presets of tune and limits of ramps are kept and found there.")
]
TermOption = Annotated[
    list[str] | None, typer.Option("--with-term", help="A further torque term, as quadratic_drag; may be repeated.")
]
FixOption = Annotated[list[str] | None, typer.Option("--fix", help="Hold NAME=VALUE fixed.")]
CalibrationOption = Annotated[Path | None, typer.Option("--calibration", help="Use the calibration in this file.")]


def models_folder(folder: Path | None) -> Path:
    """The folder of adopted models; default: where `serve` keeps them."""
    return folder or Path("data", "models")


def overrides(platform: str, given: list[str] | None, real_time: bool) -> tuple[str, ...]:
    """What differs from the platform file: --real-time, and then what --set says.  Raises ConfigError, InputError."""
    from platform_daemon.core.settings import real_time_overrides

    return (*(real_time_overrides(platform) if real_time else ()), *(given or ()))


@dataclass(frozen=True, kw_only=True)
class PlatformOptions:
    """The platform that a command works on: its file, and what differs from the file."""

    platform: PlatformOption = "simulated"
    overrides: SetOption = None
    endpoints: EndpointsOption = None
    real_time: RealTimeOption = False

    def load(self) -> PlatformFile:
        """The platform.  Raises ConfigError, InputError."""
        from platform_daemon.core.settings import load_platform

        return load_platform(self.platform, overrides(self.platform, self.overrides, self.real_time), self.endpoints)


@dataclass(frozen=True, kw_only=True)
class KeptOptions:
    """Where what was found for a resonator is kept and looked for: presets, limits of ramps, adopted models."""

    data: DataOption = Path("data")
    presets: PresetsOption = None
    models: ModelsOption = None


@dataclass(frozen=True, kw_only=True)
class LabOptions(PlatformOptions):
    """The same, for commands that are about real devices."""

    platform: PlatformOption = "lab"


@dataclass(frozen=True, kw_only=True)
class ResultOptions:
    """Where a command writes its result, over a file that exists only if `force`."""

    json_file: JsonOption = None
    force: ForceOption = False

    def check(self) -> None:
        """Raises InputError if the result cannot be written."""
        must_not_exist(self.json_file, self.force, ".json")


@dataclass(frozen=True, kw_only=True)
class TableOptions(ResultOptions):
    """The same for a command that prints a table."""

    csv_file: CsvOption = None

    def check(self) -> None:
        """Raises InputError if result or table cannot be written."""
        super().check()
        must_not_exist(self.csv_file, self.force, ".csv")


@contextmanager
def engine_of(where: PlatformOptions, models: Path | None = None) -> Iterator[Engine]:
    """The engine of a platform; it is closed at the end, which switches outputs off.

    models: folder of adopted models that fits may use, None: none.
    """
    engine = import_module(_ASSEMBLY).start_engine(where.load(), models=models)
    try:
        yield engine
    finally:
        engine.close()


@contextmanager
def measuring_engine(where: PlatformOptions, kept: KeptOptions, *, dry_run: bool = False) -> Iterator[Engine]:
    """The same with the adopted models, the presets and the limits of these folders.

    dry_run: for planning only, without shots.
    """
    assembly = import_module(_ASSEMBLY)
    engine = assembly.start_engine(
        where.load(),
        models=models_folder(kept.models),
        catalogue=assembly.kept_catalogue(kept.data, kept.presets),
        warms_up=not dry_run,
    )
    try:
        yield engine
    finally:
        engine.close()


def calibration_in(file: Path | None) -> tuple[ReceiveCalibration, str] | None:
    """A calibration in the place of the files' own, and where it came from.  Raises RecordingError."""
    from platform_daemon.core.recordings.reader import read_calibration

    return None if file is None else (read_calibration(file), str(file))
