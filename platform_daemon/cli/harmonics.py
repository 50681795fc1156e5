"""`platform-daemon harmonics`: a second look at every frame, without a fit."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drivers.errors import InputError, PlatformError
from platform_daemon.schemas import (
    PARAMETERS,
    FileError,
    HarmonicEstimate,
    HarmonicsBatch,
    HarmonicsReport,
    RefusedHarmonicEstimate,
)

from .options import CalibrationOption, ForceOption, FramesOption, JsonOption, calibration_in
from .output import must_not_exist, write_json

if TYPE_CHECKING:
    from platform_daemon.analysis import Harmonics, VoltageMeasurement


def harmonics(
    files: Annotated[list[Path], typer.Argument(help="Recordings.")],
    frames: FramesOption = None,
    calibration: CalibrationOption = None,
    json_file: JsonOption = None,
    force: ForceOption = False,
) -> None:
    """Read f_nat, m_r, amplitude and decay off the harmonics of the first 24 periods: a cross-check of the fit."""
    from platform_daemon.analysis import error_summary, open_voltages

    from .parsing import parse_frames

    chosen = None if frames is None else parse_frames(frames)
    must_not_exist(json_file, force, ".json")
    other = calibration_in(calibration)
    entries: list[HarmonicsReport | FileError] = []
    errors: list[PlatformError] = []
    for path in dict.fromkeys(files):
        try:
            entries.append(_file(open_voltages(path, other), chosen, named=len(files) > 1))
        except PlatformError as error:
            if len(files) == 1:
                raise
            errors.append(error)
            entries.append(FileError(file=str(path), error=error_summary(error)))
            print(f"{path}: error: {error}", file=sys.stderr)
    write_json(json_file, entries[0] if len(files) == 1 else HarmonicsBatch(files=tuple(entries)))
    if errors:
        raise typer.Exit(2 if all(isinstance(e, InputError) for e in errors) else 1)
    if not any(f.verdict == "good" for entry in entries if isinstance(entry, HarmonicsReport) for f in entry.frames):
        print("every frame was refused", file=sys.stderr)
        raise typer.Exit(3)


def _file(measurement: VoltageMeasurement, asked: tuple[int, ...] | None, *, named: bool) -> HarmonicsReport:
    """What the frames of one file tell, each told as it comes.  Raises InputError if none can be read."""
    from platform_daemon.analysis import chosen_frames, frame_harmonics, reason_of

    path, used = measurement.path, measurement.calibration
    frames: list[Harmonics] = []
    unreadable = []
    for k in chosen_frames(measurement, asked):
        try:
            frames.append(frame_harmonics(measurement, k))
        except PlatformError as error:
            frames.append(RefusedHarmonicEstimate(frame=k, verdict="refused", reason=reason_of(error)))
            unreadable.append(error)
        print((f"{path}: " if named else "") + harmonics_line(frames[-1]), flush=True)
    if len(unreadable) == len(frames):
        raise unreadable[0]
    return HarmonicsReport(
        file=str(path), calibration=None if used is None else used.identifier, frames=tuple(frames)
    )  # fmt: skip


def harmonics_line(frame: Harmonics) -> str:
    """One frame on one line, in the units of the fit's table."""
    if not isinstance(frame, HarmonicEstimate):
        return f"frame {frame.frame}: refused: {frame.reason}"
    rodrigues = ", ".join(f"{x:.4f}" for x in frame.rodrigues_rad)
    moment = frame.m_r_am2 * PARAMETERS["m_r_am2"].display_factor
    return (
        f"frame {frame.frame}: f_nat {frame.f_nat_hz:.4f} Hz, m_r {moment:.4f} mAm², "
        f"amplitude {math.degrees(frame.amplitude_rad):.3f}° and f {frame.frequency_hz:.4f} Hz at "
        f"{frame.time_s:.3f} s, decay {frame.decay_per_s:.4f} s⁻¹, orientation ({rodrigues}), "
        f"second harmonic {frame.second_harmonic_snr:.3g} times the noise"
    )
