"""`platform-daemon sweep`: the same series again and again with other values of some keys, in one recording."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from drivers.errors import InputError
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
from .parsing import parse_number, parse_points, parse_window
from .procedure import conduct

if TYPE_CHECKING:
    from platform_daemon.schemas import SweepRequest

_RULE = re.compile(r"\s*(\w+)\s*(>=|<=|>|<)\s*(\S+)\s*")


def sweep(
    resonator: Annotated[str, typer.Option(help="thread, jewel, or a resonator file.")],
    over: Annotated[
        list[str],
        typer.Option(help="KEY=FROM:TO:STEP or KEY=A,B,C; several: all combinations, the last changes fastest."),
    ],
    out: Annotated[
        Path | None, typer.Option("--output", "--out", help="Recording to write; default: sweep.h5.")
    ] = None,
    shots: Annotated[int, typer.Option(min=0, help="Excited shots per step.")] = 1,
    blank_shots: Annotated[int, typer.Option(min=0, help="Shots without excitation before them, per step.")] = 0,
    stop_when: Annotated[str | None, typer.Option(help="RESULT OP VALUE that ends it, as 'phi_max_deg > 40'.")] = None,
    field_ut: Annotated[float | None, typer.Option(help="Excitation field, uT; default: the preset's.")] = None,
    rx_s: Annotated[float | None, typer.Option(help="RX window, s; default: the preset's.")] = None,
    pause_s: Annotated[float | None, typer.Option(help="Wait between shots, s; default: the preset's.")] = None,
    window: WindowOption = "d30",
    variant: Annotated[str | None, typer.Option(help="Model of the on-line fits; default: the resonator's.")] = None,
    models: ModelsOption = None,
    presets: PresetsOption = None,
    sample: Annotated[str, typer.Option(help="Sample name for the record.")] = "",
    operator: Annotated[str, typer.Option(help="Operator for the record.")] = "",
    comment: Annotated[str, typer.Option(help="Comment for the record.")] = "",
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Check every step and show the plan; nothing moves.")
    ] = False,
    platform: PlatformOption = "simulated",
    overrides: SetOption = None,
    endpoints: EndpointsOption = None,
    json_file: JsonOption = None,
    force: ForceOption = False,
) -> None:
    """Sweep keys of a series: every step is fitted and logged, all shots are in one recording."""
    from platform_daemon.app import start_engine
    from platform_daemon.settings import load_platform

    sequence = {"field_t": None if field_ut is None else field_ut * 1e-6, "rx_s": rx_s, "pause_s": pause_s}
    common: dict[str, Any] = {
        "resonator": resonator,
        "shots": shots,
        "blank_shots": blank_shots,
        "sequence": {name: value for name, value in sequence.items() if value is not None},
        "window": parse_window(window),
        "variant": variant,
    } | {"sample": sample, "operator": operator, "comment": comment}
    request = _request(common, over, stop_when)
    out = out or Path("sweep.h5")
    must_not_exist(json_file, force, ".json")
    must_not_exist(None if dry_run else out, force, ".h5", ".hdf5", ".mmr")
    heed_one_interrupt()
    engine = start_engine(
        load_platform(platform, overrides or (), endpoints), models=library(models), catalogue=catalogue(presets)
    )
    try:
        conduct(engine, request, out, json_file, dry_run=dry_run, overwrite=force)
    finally:
        engine.close()


def _request(common: dict[str, Any], over: list[str], stop_when: str | None) -> SweepRequest:
    """Raises InputError."""
    from platform_daemon.schemas import SweepRequest

    axes = [parse_points(text, "--over") for text in over]
    rule = None if stop_when is None else _rule(stop_when)
    asked = {"kind": "sweep", "acquisition": common, "over": axes, "stop_when": rule}
    return validated(SweepRequest, asked, "sweep")


def _rule(text: str) -> dict[str, Any]:
    """RESULT OP VALUE.  Raises InputError."""
    found = _RULE.fullmatch(text)
    value = None if found is None else parse_number(found[3])
    if found is None or value is None:
        remedy = "write RESULT OP VALUE with >, <, >= or <=, as 'phi_max_deg > 40'"
        raise InputError(f"{text!r} is no rule", where="--stop-when", remedy=remedy)
    return {"result": found[1], "comparison": found[2], "value": value}
