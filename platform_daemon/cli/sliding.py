"""`platform-daemon slide`: fits along one ring-down, window by window."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drivers.errors import InputError

from .options import CalibrationOption, ForceOption, JsonOption, ModelsOption, TermOption, VariantOption, variant_named
from .output import must_not_exist, write_json

if TYPE_CHECKING:
    from platform_daemon.analysis import ModelChoice
    from platform_daemon.estimation import SlidingFit


def slide(
    file: Path,
    frame: Annotated[int, typer.Option(min=0, help="Frame, from 0.")] = 0,
    window: Annotated[float | None, typer.Option(help="Length of a window, s; default: an eighth of D30.")] = None,
    step: Annotated[float | None, typer.Option(help="From window to window, s; default: no overlap.")] = None,
    damping: Annotated[str, typer.Option("--lambda", help="Jewel: auto, free or fixed (to the D30 value).")] = "auto",
    variant: VariantOption = None,
    term: TermOption = None,
    models: ModelsOption = None,
    calibration: CalibrationOption = None,
    out: Annotated[Path | None, typer.Option(help="PNG to write.")] = None,
    json_file: JsonOption = None,
    force: ForceOption = False,
) -> None:
    """Fit window by window: with a complete model f_nat, m_r, lambda and T_f/I are flat lines."""
    from platform_daemon.analysis import FitRefused, flatness_lines, sliding_report
    from platform_daemon.reports import save_sliding_png

    must_not_exist(out, force)
    must_not_exist(json_file, force)
    try:
        found, held = _slid(
            file, frame, damping, (window, step), variant_named(variant, models), term or [], calibration
        )
    except FitRefused as refused:
        print(f"error: {refused}", file=sys.stderr)
        raise typer.Exit(3) from None
    print("\n".join(flatness_lines(found)))
    if out is not None:
        save_sliding_png(found, f"{file.name}, frame {frame}, {variant or held}", out)
        print(out)
    write_json(json_file, {"file": str(file), "frame": frame, **sliding_report(found)})
    if not any(w.fit.verdict == "good" for w in found.windows):
        print("every window was refused", file=sys.stderr)
        raise typer.Exit(3)


def _slid(
    file: Path,
    frame: int,
    damping: str,
    lengths: tuple[float | None, float | None],
    variant: ModelChoice | None,
    terms: list[str],
    calibration: Path | None,
) -> tuple[SlidingFit, str | None]:
    """The fits along a frame, or along an angle; with what the file says it holds.  Raises InputError."""
    from platform_daemon.analysis import PENDULUM, refuse_calibration, slide_angles, slide_frame
    from platform_daemon.estimation import LambdaMode
    from platform_daemon.store import is_time_series, open_recording, read_angles, read_calibration

    if damping not in ("auto", "free", "fixed"):
        raise InputError(f"no mode {damping!r}", where="--lambda", remedy="give auto, free or fixed")
    mode: LambdaMode = damping  # type: ignore[assignment]
    other = None if calibration is None else (read_calibration(calibration), str(calibration))
    names = "--window", "--step"
    if is_time_series(file):
        series = read_angles(file)
        refuse_calibration(series, other)
        if frame:
            raise InputError(f"frame {frame} does not exist", where=str(file), remedy="an angle file has frame 0 only")
        return slide_angles(series, variant, *lengths, mode, terms=terms, options=names), PENDULUM
    recording = open_recording(file)
    if other is not None:
        recording = recording.with_calibration(*other)
    return slide_frame(recording, frame, variant, *lengths, mode, terms=terms, options=names), recording.variant
