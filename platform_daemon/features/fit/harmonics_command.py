"""`platform-daemon harmonics`: a second look at every frame, without a fit."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drivers.errors import InputError, PlatformError
from platform_daemon.core.command_line.options import (
    CalibrationOption,
    ForceOption,
    FramesOption,
    JsonOption,
    calibration_in,
)
from platform_daemon.core.command_line.output import must_not_exist, say_note, write_json

if TYPE_CHECKING:
    from platform_daemon.core.schemas.fits import FileError
    from platform_daemon.core.schemas.harmonics import HarmonicsReport

    from .harmonics import Harmonics
    from .measurement import VoltageMeasurement


def harmonics(
    files: Annotated[list[Path], typer.Argument(help="Recordings.")],
    frames: FramesOption = None,
    calibration: CalibrationOption = None,
    json_file: JsonOption = None,
    force: ForceOption = False,
) -> None:
    """Estimate f_nat, m_r, amplitude and decay from the harmonics of 24 periods: a cross-check of the fit."""
    from platform_daemon.core.command_line.parsing import parse_frames
    from platform_daemon.core.schemas.fits import FileError
    from platform_daemon.core.schemas.harmonics import HarmonicsBatch, HarmonicsReport

    from .batch.ledger import error_summary
    from .measurement import open_voltages

    chosen = None if frames is None else parse_frames(frames)
    must_not_exist(json_file, force, ".json")
    other = calibration_in(calibration)
    entries: list[HarmonicsReport | FileError] = []
    errors: list[PlatformError] = []
    for path in dict.fromkeys(files):
        try:
            entries.append(_file(open_voltages(path, other), chosen))
        except PlatformError as error:
            if len(files) == 1:
                raise
            errors.append(error)
            entries.append(FileError(file=str(path), error=error_summary(error)))
            print(f"{path}: error: {error}", file=sys.stderr)
    write_json(json_file, entries[0] if len(files) == 1 else HarmonicsBatch(files=tuple(entries)))
    for entry in entries:
        if isinstance(entry, HarmonicsReport):
            for each in entry.frames:
                print((f"{entry.file}: " if len(files) > 1 else "") + harmonics_line(each))
                for doubt in _doubts(each):
                    say_note(Path(entry.file), f"frame {each.frame}: {doubt}")
    if errors:
        raise typer.Exit(2 if all(isinstance(e, InputError) for e in errors) else 1)
    verdicts = {f.verdict for entry in entries if isinstance(entry, HarmonicsReport) for f in entry.frames}
    if "good" not in verdicts:
        print("no frame was excited" if verdicts == {"blank"} else "every frame was refused", file=sys.stderr)
        raise typer.Exit(3)


def _file(measurement: VoltageMeasurement, chosen: tuple[int, ...] | None) -> HarmonicsReport:
    """The harmonics of the frames of one file.  Raises InputError if none can be read."""
    from platform_daemon.core.schemas.harmonics import HarmonicsReport, RefusedHarmonicEstimate

    from .calibrated import reason_of
    from .frames import chosen_frames
    from .harmonics import frame_harmonics

    path, used = measurement.path, measurement.calibration
    say_note(path, measurement.other_layout)
    frames: list[Harmonics] = []
    unreadable = []
    for k in chosen_frames(measurement, chosen):
        try:
            frames.append(frame_harmonics(measurement, k))
        except PlatformError as error:
            frames.append(RefusedHarmonicEstimate(frame=k, verdict="refused", reason=reason_of(error)))
            unreadable.append(error)
    if len(unreadable) == len(frames):
        raise unreadable[0]
    return HarmonicsReport(
        file=str(path), calibration=None if used is None else used.identifier, frames=tuple(frames)
    )  # fmt: skip


def _doubts(frame: Harmonics) -> tuple[str, ...]:
    """As of a fit: what no resonator has."""
    from platform_daemon.core.schemas.harmonics import HarmonicEstimate
    from platform_daemon.estimation.goodness_of_fit.plausibility import plausibility_warnings
    from platform_daemon.estimation.parameters import Estimate

    if not isinstance(frame, HarmonicEstimate):
        return ()
    values = {"f_nat_hz": frame.f_nat_hz, "m_r_am2": frame.m_r_am2}
    return plausibility_warnings("dmdt", {name: Estimate(value, 0.0) for name, value in values.items()})


def harmonics_line(frame: Harmonics) -> str:
    """One frame on one line, in the units of the fit's table."""
    from platform_daemon.core.schemas.harmonics import HarmonicEstimate
    from platform_daemon.core.schemas.parameters import PARAMETERS

    if not isinstance(frame, HarmonicEstimate):
        refused = "" if frame.verdict == "blank" else "refused: "
        return f"frame {frame.frame}: {refused}{frame.reason}"
    rodrigues = ", ".join(f"{x:.4f}" for x in frame.rodrigues_rad)
    moment = frame.m_r_am2 * PARAMETERS["m_r_am2"].display_factor
    return (
        f"frame {frame.frame}: f_nat {frame.f_nat_hz:.4f} Hz, m_r {moment:.4f} mAm², "
        f"amplitude {math.degrees(frame.amplitude_rad):.3f}° and f {frame.frequency_hz:.4f} Hz at "
        f"{frame.time_s:.3f} s, decay {frame.decay_per_s:.4f} s⁻¹, orientation ({rodrigues}), "
        f"second harmonic {frame.second_harmonic_snr:.3g} times the noise"
    )
