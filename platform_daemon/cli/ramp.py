"""`platform-daemon ramp`: the field at which side modes show, found without going far beyond it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from drivers.validation import validated

from .interrupts import heed_one_interrupt
from .options import (
    BeyondOption,
    EndpointsOption,
    ForceOption,
    JsonOption,
    ModelsOption,
    PlatformOption,
    SetOption,
    catalogue,
    library,
)
from .output import must_not_exist, write_json
from .procedure import conduct

if TYPE_CHECKING:
    from platform_daemon.schemas import ProcedureResult, RampOutcome


def ramp(
    resonator: Annotated[str, typer.Option(help="thread_imperfect, jewel, or a resonator file.")],
    out: Annotated[Path | None, typer.Option("--output", "--out", help="Recording to write; default: ramp.h5.")] = None,
    axis: Annotated[str | None, typer.Option(help="Axis of the excitation: x, y or z; default: the preset's.")] = None,
    start_ut: Annotated[float | None, typer.Option(help="First field, uT; default: half the preset's.")] = None,
    step_ut: Annotated[float, typer.Option(help="Highest step, uT.")] = 10.0,
    max_ut: Annotated[float | None, typer.Option(help="Highest field, uT; default: the platform's limit.")] = None,
    overdose_rate: Annotated[float, typer.Option(help="Chance, of each step, to lie above the threshold.")] = 0.25,
    most_shots: Annotated[int, typer.Option(help="Shots at one field at most.")] = 6,
    rx_s: Annotated[float | None, typer.Option(help="RX window, s; default: 2 s, or the preset's.")] = None,
    pause_s: Annotated[float | None, typer.Option(help="Wait between shots, s; default: until it rests.")] = None,
    beyond_side_modes: BeyondOption = False,
    sample: Annotated[str, typer.Option(help="Sample name for the record.")] = "",
    operator: Annotated[str, typer.Option(help="Operator for the record.")] = "",
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Check every step and show the plan; nothing moves.")
    ] = False,
    png: Annotated[Path | None, typer.Option(help="Picture of the ramp to write.")] = None,
    platform: PlatformOption = "simulated",
    overrides: SetOption = None,
    endpoints: EndpointsOption = None,
    models: ModelsOption = None,
    json_file: JsonOption = None,
    force: ForceOption = False,
) -> None:
    """Raise the field until side modes show; find their threshold and the field to work at."""
    from platform_daemon.app import start_engine
    from platform_daemon.schemas import RampOutcome, RampRequest
    from platform_daemon.settings import load_platform

    fields = {"step_t": step_ut, "start_t": start_ut, "max_t": max_ut}
    asked = {
        "kind": "ramp",
        "acquisition": _common(resonator, {"axis": axis, "rx_s": rx_s, "pause_s": pause_s}, beyond_side_modes)
        | {"sample": sample, "operator": operator},
        "overdose_rate": overdose_rate,
        "most_shots": most_shots,
    } | {name: 1e-6 * value for name, value in fields.items() if value is not None}
    request = validated(RampRequest, asked, "ramp")
    out = out or Path("ramp.h5")
    must_not_exist(json_file, force, ".json")
    must_not_exist(png, force, ".png")
    must_not_exist(None if dry_run else out, force, ".h5", ".hdf5", ".mmr")
    heed_one_interrupt()
    engine = start_engine(
        load_platform(platform, overrides or (), endpoints), models=library(models), catalogue=catalogue(None)
    )

    def tell(result: ProcedureResult) -> None:
        _tell(result.outcome if isinstance(result.outcome, RampOutcome) else None, json_file, png)

    try:
        conduct(engine, request, out, None, dry_run=dry_run, overwrite=force, tell=tell)
    finally:
        engine.close()


def _common(resonator: str, sequence: dict[str, Any], beyond: bool) -> dict[str, Any]:
    """What all steps have in common."""
    given = {name: value for name, value in sequence.items() if value is not None}
    return {"resonator": resonator, "sequence": given} | ({"beyond_side_modes": True} if beyond else {})


def _tell(found: RampOutcome | None, json_file: Path | None, png: Path | None) -> None:
    from platform_daemon.reports import ramp_text, save_ramp_png  # here, because matplotlib is loaded with it

    if found is None:
        return
    print(ramp_text(found))
    write_json(json_file, found)
    if png is not None:
        save_ramp_png(found, png)
        print(png)
