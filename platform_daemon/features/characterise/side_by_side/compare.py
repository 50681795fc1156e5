"""`characterise --compare`: two specimens of anybody beside each other, in a folder."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from platform_daemon.core.command_line.output import write_json
from platform_daemon.features.characterise.schema import CharacterisationReport
from platform_daemon.features.characterise.tables import CharacterisationTask

from .figures import measured_figures
from .folder import SideBySide, write_folder
from .noise_schema import BreakEven, NoiseSweepReport
from .tables import tables_of


def write_comparison(
    folder: Path,
    tasks: Mapping[str, CharacterisationTask],
    reports: Mapping[str, CharacterisationReport],
    noise: NoiseSweepReport | None,
) -> None:
    """The report of the paper without its numbers, and each specimen's as JSON.  Raises PlatformError."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, report in reports.items():
        write_json(folder / f"{name}.json", report)
    write_json(folder / "noise.json", noise)
    said = [f"{name}: {report.file}" for name, report in reports.items()]
    said += [f"{name}: {note}" for name, report in reports.items() for note in report.notes]
    said += [] if noise is None else [break_even_text(found, list(reports)) for found in noise.break_even]
    told = SideBySide(
        title=" and ".join(reports),
        said=said,
        tables=list(tables_of(reports)),
        figures=list(measured_figures(reports, tasks, noise)),
    )
    write_folder(folder, told)


def break_even_text(found: BreakEven, names: list[str]) -> str:
    """In words."""
    what = "f_nat" if found.quantity == "f_nat_hz" else "the orientation"
    if found.level_am2_per_s is None:
        return f"no break-even of {what}: {found.reason} ({names[1]} against {names[0]})"
    ends = found.interval_am2_per_s
    within = "" if ends is None else f", 95 % within {ends[0]:.3g} and {ends[1]:.3g}"
    return f"{names[1]} is the more precise one in {what} from {found.level_am2_per_s:.3g} A m2/s on{within}"
