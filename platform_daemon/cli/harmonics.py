"""`platform-daemon harmonics`: a second look at every frame, without a fit."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from drivers.errors import InputError, PlatformError

from .options import CalibrationOption, ForceOption, FramesOption, JsonOption
from .output import must_not_exist, write_json


def harmonics(
    files: Annotated[list[Path], typer.Argument(help="Recordings.")],
    frames: FramesOption = None,
    calibration: CalibrationOption = None,
    json_file: JsonOption = None,
    force: ForceOption = False,
) -> None:
    """Read f_nat, m_r, amplitude and decay off the harmonics of the first 24 periods: a cross-check of the fit."""
    from platform_daemon.store import read_calibration

    from .parsing import parse_frames

    chosen = None if frames is None else parse_frames(frames)
    must_not_exist(json_file, force)
    other = None if calibration is None else (read_calibration(calibration), str(calibration))
    entries: list[dict[str, Any]] = []
    errors: list[PlatformError] = []
    for path in dict.fromkeys(files):
        try:
            entries.append(_file(path, chosen, other, named=len(files) > 1))
        except PlatformError as error:
            if len(files) == 1:
                raise
            errors.append(error)
            entries.append({"file": str(path), "error": {"title": error.title, "detail": str(error)}})
            print(f"{path}: error: {error}", file=sys.stderr)
    write_json(json_file, entries[0] if len(files) == 1 else {"files": entries})
    if errors:
        raise typer.Exit(2 if all(isinstance(e, InputError) for e in errors) else 1)
    if not any(f["verdict"] == "good" for entry in entries for f in entry["frames"]):
        print("every frame was refused", file=sys.stderr)
        raise typer.Exit(3)


def _file(
    path: Path, asked: tuple[int, ...] | None, calibration: tuple[Any, str] | None, *, named: bool
) -> dict[str, Any]:
    """What the frames of one file tell, each told as it comes.  Raises InputError if none can be read."""
    from platform_daemon.analysis import chosen_frames
    from platform_daemon.store import open_recording

    recording = open_recording(path)
    if calibration is not None:
        recording = recording.with_calibration(*calibration)
    frames, unreadable = [], []
    for k in chosen_frames(recording, asked):
        report, error = _frame(recording, k)
        unreadable += [] if error is None else [error]
        frames.append({"frame": k, **report})
        print((f"{path}: " if named else "") + harmonics_line(frames[-1]), flush=True)
    if len(unreadable) == len(frames):
        raise unreadable[0]
    used = recording.calibration
    return {"file": str(path), "calibration": None if used is None else used.identifier, "frames": frames}


def _frame(recording: Any, k: int) -> tuple[dict[str, Any], PlatformError | None]:
    """The report of a frame; of one that cannot be read, its refusal and the error."""
    from platform_daemon.analysis import frame_harmonics, reason_of

    try:
        return frame_harmonics(recording, k), None
    except PlatformError as error:
        return {"verdict": "refused", "reason": reason_of(error)}, error


def harmonics_line(frame: Mapping[str, Any]) -> str:
    """One frame on one line, in the units of the fit's table."""
    if frame["verdict"] != "good":
        return f"frame {frame['frame']}: refused: {frame['reason']}"
    rodrigues = ", ".join(f"{x:.4f}" for x in frame["rodrigues_rad"])
    return (
        f"frame {frame['frame']}: f_nat {frame['f_nat_hz']:.4f} Hz, m_r {1e3 * frame['m_r_am2']:.4f} mAm², "
        f"amplitude {math.degrees(frame['amplitude_rad']):.3f}° and f {frame['frequency_hz']:.4f} Hz at "
        f"{frame['time_s']:.3f} s, decay {frame['decay_per_s']:.4f} s⁻¹, orientation ({rodrigues}), "
        f"second harmonic {frame['second_harmonic_snr']:.3g} times the noise"
    )
