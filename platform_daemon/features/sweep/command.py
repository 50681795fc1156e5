"""`platform-daemon sweep`: the same series again and again with other values of some keys, in one recording."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from drivers.errors import InputError
from platform_daemon.core.command_line.interrupts import heed_one_interrupt
from platform_daemon.core.command_line.options import (
    KeptOptions,
    PlatformOptions,
    TableOptions,
    measuring_engine,
)
from platform_daemon.core.command_line.parsing import parse_number, parse_points
from platform_daemon.core.command_line.recording_target import prepare_target
from platform_daemon.core.command_line.request_options import Keys, offers, option_groups

if TYPE_CHECKING:
    from .schema import SweepRequest

_RULE = re.compile(r"\s*(\w+)\s*(>=|<=|>|<)\s*(\S+)\s*")


STEP = offers(
    "SweepRequest",
    "acquisition.resonator",
    "acquisition.preset",
    "acquisition.shots",
    "acquisition.blank_shots",
    "acquisition.sequence.field_ut",
    "acquisition.sequence.rx_s",
    "acquisition.sequence.pause_s",
    "acquisition.window",
    "acquisition.variant",
    "acquisition.sample",
    "acquisition.operator",
    "acquisition.comment",
    changes={
        "acquisition.shots": {"help": "Excited shots per step."},
        "acquisition.blank_shots": {"help": "Shots without excitation before them, per step."},
    },
)


@option_groups
def sweep(
    *,
    step: Annotated[Keys, STEP],
    over: Annotated[
        list[str],
        typer.Option(help="KEY=FROM:TO:STEP or KEY=A,B,C; several: all combinations, the last changes fastest."),
    ],
    stop_when: Annotated[str | None, typer.Option(help="RESULT OP VALUE that ends it, as 'phi_max_deg > 40'.")] = None,
    out: Annotated[Path, typer.Option("--output", "--out", help="Recording to write.")] = Path("sweep.h5"),
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Check every step and show the plan; nothing moves.")
    ] = False,
    kept: KeptOptions,
    where: PlatformOptions,
    result: TableOptions,
) -> None:
    """Sweep keys of a series: every step is fitted and logged, all shots are in one recording."""
    from platform_daemon.features.procedures.command import conduct

    request = _request(step, over, stop_when)
    result.check()
    prepare_target(out, force=result.force, dry_run=dry_run)
    heed_one_interrupt()
    with measuring_engine(where, kept, dry_run=dry_run) as engine:
        conduct(
            engine,
            request,
            out,
            result.json_file,
            dry_run=dry_run,
            overwrite=result.force,
            csv_file=result.csv_file,
        )


def _request(step: Keys, over: list[str], stop_when: str | None) -> SweepRequest:
    """Raises InputError."""
    from drivers.validation import validated

    from .schema import SweepRequest

    axes = [parse_points(text, "--over") for text in over]
    rule = None if stop_when is None else _rule(stop_when)
    return validated(SweepRequest, {"kind": "sweep", **step, "over": axes, "stop_when": rule}, "sweep")


def _rule(text: str) -> dict[str, Any]:
    """RESULT OP VALUE.  Raises InputError."""
    found = _RULE.fullmatch(text)
    value = None if found is None else parse_number(found[3])
    if found is None or value is None:
        remedy = "write RESULT OP VALUE with >, <, >= or <=, as 'phi_max_deg > 40'"
        raise InputError(f"{text!r} is no rule", where="--stop-when", remedy=remedy)
    return {"result": found[1], "comparison": found[2], "value": value}
