"""`platform-daemon tune`: find a resonator's frequency, and the sequence that it is measured best with."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from drivers.validation import validated

from .interrupts import heed_one_interrupt
from .options import (
    EndpointsOption,
    ForceOption,
    JsonOption,
    ModelsOption,
    PlatformOption,
    PresetsOption,
    SetOption,
    WindowOption,
    catalogue,
    library,
)
from .output import must_not_exist
from .parsing import parse_axis, parse_window
from .procedure import conduct


def tune(
    resonator: Annotated[str, typer.Option(help="thread, jewel, or a resonator file.")],
    out: Annotated[Path | None, typer.Option("--output", "--out", help="Recording to write; default: tune.h5.")] = None,
    f_tx_hz: Annotated[
        float | None, typer.Option(help="Where the search begins, Hz; default: the design's natural frequency.")
    ] = None,
    weak_field_ut: Annotated[
        float | None, typer.Option(help="Field of the first shot, uT; default: a swing of some degrees by design.")
    ] = None,
    max_field_ut: Annotated[
        float | None, typer.Option(help="Highest field that it may raise that to, uT; default: the platform's.")
    ] = None,
    field_ut: Annotated[
        float | None, typer.Option(help="Field of the sequence that is found, uT; default: the preset's.")
    ] = None,
    axis: Annotated[str | None, typer.Option(help="x, y, z or a direction as 1,0,0.5; default: the preset's.")] = None,
    keep: Annotated[bool, typer.Option(help="Keep what is found as the resonator's preset.")] = True,
    presets: PresetsOption = None,
    window: WindowOption = "d30",
    variant: Annotated[str | None, typer.Option(help="Model of the fits; default: the resonator's.")] = None,
    models: ModelsOption = None,
    sample: Annotated[str, typer.Option(help="Sample name for the record.")] = "",
    operator: Annotated[str, typer.Option(help="Operator for the record.")] = "",
    comment: Annotated[str, typer.Option(help="Comment for the record.")] = "",
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Check the shots and show the plan; nothing moves.")
    ] = False,
    platform: PlatformOption = "simulated",
    overrides: SetOption = None,
    endpoints: EndpointsOption = None,
    json_file: JsonOption = None,
    force: ForceOption = False,
) -> None:
    """Find f_nat in at most five weak shots, and from it f_TX, t_TX, t_RX and the pause; kept as the preset."""
    from platform_daemon.app import start_engine
    from platform_daemon.schemas import TuneRequest
    from platform_daemon.settings import load_platform

    direction = None if axis is None else parse_axis(axis)
    keys = {"f_tx_hz": f_tx_hz, "field_t": _tesla(field_ut), "axis": direction}
    common: dict[str, Any] = {
        "resonator": resonator,
        "sequence": {name: value for name, value in keys.items() if value is not None},
        "window": parse_window(window),
        "variant": variant,
    } | {"sample": sample, "operator": operator, "comment": comment}
    fields = {"weak_field_t": _tesla(weak_field_ut), "max_field_t": _tesla(max_field_ut)}
    request = validated(TuneRequest, {"kind": "tune", "acquisition": common, **fields, "keep": keep}, "tune")
    out = out or Path("tune.h5")
    must_not_exist(json_file, force, ".json")
    must_not_exist(None if dry_run else out, force, ".h5", ".hdf5", ".mmr")
    heed_one_interrupt()
    file = load_platform(platform, overrides or (), endpoints)
    engine = start_engine(file, models=library(models), catalogue=catalogue(presets))
    try:
        conduct(engine, request, out, json_file, dry_run=dry_run, overwrite=force)
    finally:
        engine.close()


def _tesla(field_ut: float | None) -> float | None:
    return None if field_ut is None else field_ut * 1e-6
