"""What a recording holds, in tables as wide as the terminal; what the file does not say is not shown."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from platform_daemon.core.recordings.column_file import is_column_file, lines_missing
from platform_daemon.core.schemas.control_characters import printable
from platform_daemon.core.schemas.recordings import (
    AngleInfo,
    CalibrationInfo,
    ExcitationInfo,
    FrameDescription,
    RecordingInfo,
    TableColumn,
)
from platform_daemon.core.schemas.value_sources import value_sources_text

MOST_SHOTS = 200  # shown one by one
_AXES = ("x", "y", "z")
_IS_DMDT = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
"""Sensitivity, T/A, of samples that are dm/dt; no coils have it, a tesla per ampere is some 25 times theirs."""
_LAYOUTS = {"own": "layout of this software", "minimal": "public MMR layout"}


def print_recording(info: RecordingInfo) -> None:
    """Facts, windows, calibration, excitation and shots of a recording, on standard output."""
    console = Console(markup=False, highlight=False)
    console.print(_facts(info))
    console.print(_windows(info))
    if info.calibration is not None and info.calibration.sensitivity == _IS_DMDT:
        console.print("the samples are dm/dt in A m²/s already, along x, y and z; there is no calibration")
    elif info.calibration is not None:
        console.print(f"calibration {printable(info.calibration.id or 'without a name')}: sensitivity / mT A⁻¹")
        console.print(_sensitivity(info.calibration, info.channel_names))
        console.print(printable(_validity(info.calibration)))
    excitations = list(dict.fromkeys(_excitation(s.excitation) for s in info.shots if s.excitation and not s.blank))
    for text in excitations[:1] if len(excitations) == 1 else ():
        console.print(f"excitation: {printable(text)}")
    if info.value_sources:
        console.print(printable(value_sources_text(info.value_sources)))
    if info.shots:
        console.print(_shots(info.shots[:MOST_SHOTS], each_excitation=len(excitations) > 1))
    if len(info.shots) > MOST_SHOTS:
        console.print(f"and {len(info.shots) - MOST_SHOTS} more shots; --json holds all")


def print_columns(file: Path, columns: Sequence[TableColumn]) -> None:
    """The columns of a table, and the lines that it lacks, on standard output; nothing for no columns."""
    if not columns:
        return
    console = Console(markup=False, highlight=False)
    table = Table("column")
    for heading in ("rows", "unit", "from", "to", "read as"):
        table.add_column(heading, justify="left" if heading in ("unit", "read as") else "right")
    for each in columns:
        ends = ("" if value is None else f"{value:.6g}" for value in (each.lowest, each.highest))
        rows = " x ".join(map(str, each.shape))
        table.add_row(*map(printable, (each.name, rows, each.unit or "?", *ends, each.read_as or "left out")))
    console.print(table)
    lines = lines_missing(columns)
    if lines:
        units = "time in s, ms or us; a signal in V, A m^2/s, rad or deg, or with a prefix, as mV"
        print(f"{file.name}.toml next to it makes it readable, with lines as these, corrected ({units}):")
        print(*map(printable, lines), sep="\n")
        print(f"then: platform-daemon info {shlex.quote(str(file))}")


def print_angle(info: AngleInfo) -> None:
    """Facts of an angle over time, on standard output."""
    low, high = info.lowest_rad, info.highest_rad
    angle = None
    if low is not None and high is not None:
        angle = f"{math.degrees(low):.4g}° to {math.degrees(high):.4g}° ({low:.4g} to {high:.4g} rad)"
    rows = {
        "file": f"{info.file} ({info.size_bytes / 1e6:.3g} MB, {'table' if info.columns else 'angle series'})",
        "samples": str(info.samples),
        "sampling rate": f"{info.rate_hz:.8g} Hz",
        "duration": f"{info.samples / info.rate_hz:.6g} s",
        "angle": angle,
        "time": "; ".join(info.notes),
    }
    Console(markup=False, highlight=False).print(_listed(rows))


def print_next(file: Path, options: str) -> None:
    """What can be done with a file from elsewhere; options: that every such command needs."""
    command = f"{shlex.quote(str(file))}{options}"
    print(f"next: platform-daemon plot {command}, or fit, or diagnose; --variant names the model (thread, jewel, ...)")


def _facts(info: RecordingInfo) -> Table:
    rows = {
        "file": f"{info.file} ({info.size_bytes / 1e6:.3g} MB, {_kind(info)})",
        "title": info.title,
        "resonator": info.variant,
        "sample": info.sample,
        "operator": info.operator,
        "comment": info.comment,
        "started": _started(info),
        "frames": _counted(info),
        "incomplete": info.incomplete,
        "channels": f"{info.channels} ({', '.join(info.channel_names)})" if info.channel_names else str(info.channels),
        "sampling rate": _rate(info),
        "platform": info.platform,
        **info.devices,
        "software": info.software_version,
        "on-line fits": ", ".join(info.fits),
    }
    return _listed(rows)


def _listed(rows: Mapping[str, str | None]) -> Table:
    """Names and texts, those without a text left out."""
    table = Table(show_header=False, box=None)
    table.add_column(style="bold")
    table.add_column(overflow="fold")
    for name, text in rows.items():
        if text:
            table.add_row(printable(name), printable(text))
    return table


def _kind(info: RecordingInfo) -> str:
    return "table" if is_column_file(Path(info.file)) else _LAYOUTS[info.layout]


def _rate(info: RecordingInfo) -> str:
    decimated = f" ({info.base_frequency_hz:.9g} Hz / {info.decimation})" if info.decimation > 1 else ""
    return f"{info.rate_hz:.8g} Hz{decimated}"


def _started(info: RecordingInfo) -> str | None:
    return f"{info.start_time} (simulated time)" if info.clock == "simulated" else info.start_time


def _counted(info: RecordingInfo) -> str:
    """How many frames there are, blank ones apart from excited ones."""
    blank = [shot for shot in info.shots if shot.blank]
    good = info.good - sum(shot.verdict == "good" for shot in blank)
    apart = f" and {len(blank)} blank" if blank else ""
    return f"{info.frames}, of which {good} good{apart}"


def _windows(info: RecordingInfo) -> Table:
    table = Table("window")
    for heading in ("samples", "ms"):
        table.add_column(heading, justify="right")
    for name, window in info.windows:
        if window.samples:
            table.add_row(name.upper(), str(window.samples), f"{1e3 * window.seconds:.3f}")
    return table


def _sensitivity(made: CalibrationInfo, channels: tuple[str, ...]) -> Table:
    table = Table()
    for heading in ("channel", *_AXES):
        table.add_column(heading, justify="right")
    for k, row in enumerate(made.sensitivity):
        table.add_row(printable(channels[k]) if k < len(channels) else str(k), *(f"{1e3 * value:.6g}" for value in row))
    return table


def _validity(made: CalibrationInfo) -> str:
    """When and how it was made and what it holds for, as far as the file says."""
    said = (
        made.date and f"made {made.date}",
        made.lna_gain is not None and f"LNA gain {made.lna_gain:g}",
        made.relative_std is not None and f"uncertainty {made.relative_std:.2%}",
        made.valid_hz and f"holds from {made.valid_hz[0]:g} to {made.valid_hz[1]:g} Hz",
        made.valid_c and f"at {made.valid_c[0]:g} to {made.valid_c[1]:g} °C",
        made.response and f"frequency response at {made.response.points} frequencies",
        made.transmit and f"transmit side {made.transmit}",
    )
    return "; ".join(text for text in said if text)


def _shots(shots: Iterable[FrameDescription], *, each_excitation: bool) -> Table:
    table = Table()
    shots = list(shots)
    steps = any(shot.step is not None for shot in shots)
    optional = (*(("step",) if steps else ()), *(("excitation",) if each_excitation else ()))
    for heading in ("frame", "shot", "time", "T / °C", "verdict", *optional, ""):
        table.add_column(heading, overflow="fold")
    for shot in shots:
        remarks = ("blank" if shot.blank else "", shot.reason, ", ".join(shot.flags))
        cells = (
            str(shot.frame),
            str(shot.shot),
            (shot.time_stamp or "")[11:19],
            "" if shot.temperature_c is None else f"{shot.temperature_c:.2f}",
            shot.verdict,
            *([_step(shot)] if steps else []),
            *([_excitation(shot.excitation) if shot.excitation and not shot.blank else ""] if each_excitation else []),
            "; ".join(text for text in remarks if text),
        )
        table.add_row(*map(printable, cells))
    return table


def _step(shot: FrameDescription) -> str:
    values = ", ".join(f"{k} = {v if isinstance(v, str) else f'{v:g}'}" for k, v in (shot.values or {}).items())
    name = f" ({shot.step_name})" if shot.step_name else ""
    return "" if shot.step is None else f"{shot.step}: {values}{name}" if values else f"{shot.step}{name}"


def _excitation(made: ExcitationInfo) -> str:
    along = next((a for a, x in zip(_AXES, made.axis, strict=True) if abs(x) == 1.0), None)
    axis = along or "(" + ", ".join(f"{x:.3g}" for x in made.axis) + ")"
    shape = "" if made.waveform == "sine" else f" ({made.waveform})"
    return f"{made.periods:g} periods of {made.requested_hz:g} Hz, {1e6 * made.field_t:g} µT along {axis}{shape}"
