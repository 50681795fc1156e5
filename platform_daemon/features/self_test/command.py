"""`platform-daemon self-test`: is the chain as the platform file says?"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drivers.errors import InputError
from platform_daemon.core.command_line.interrupts import heed_one_interrupt
from platform_daemon.core.command_line.options import PlatformOptions, ResultOptions, engine_of
from platform_daemon.core.command_line.output import must_not_exist, write_json
from platform_daemon.core.command_line.request_options import option_groups

if TYPE_CHECKING:
    from .schema import SelfTestReport


@option_groups
def self_test(
    *,
    since: Annotated[
        Path | None, typer.Option(help="Result (--json) of an earlier self-test: by how much did gains change since?")
    ] = None,
    declare: Annotated[
        Path | None, typer.Option(help="TOML file to write: that change as `gain` of [uncertainty]; needs --since.")
    ] = None,
    where: PlatformOptions,
    result: ResultOptions,
) -> None:
    """Play a weak tone on each coil and measure its leakage: tests cables, polarity, gain and switch."""
    from platform_daemon.core.command_line.jobs import run_job
    from platform_daemon.core.state.durable import write_file

    from .declared import check_comparable, gain_declaration, read_self_test
    from .schema import SelfTestReport, SelfTestRequest
    from .work import SelfTest, SelfTestWork

    if (since is None) != (declare is None):
        remedy = "give both: --since FIRST.json --declare gain.toml"
        raise InputError("a change is between two self-tests", where="--since, --declare", remedy=remedy)
    result.check()
    must_not_exist(declare, result.force, ".toml")
    before = None if since is None else read_self_test(since)
    heed_one_interrupt()
    with engine_of(where) as engine:
        make = partial(engine.calibration_in_use.make_chain_test, enabled=True)
        if before is not None:  # a file that cannot be compared must not cost the tones
            test = make()
            assert isinstance(test, SelfTest)
            check_comparable(test.coils, test.frequency_hz, before, str(since))
        job = run_job(engine, SelfTestWork(SelfTestRequest(), make))
    assert isinstance(job.result, SelfTestReport)
    write_json(result.json_file, job.result)
    _print(job.result)
    if declare is not None and before is not None:
        text = gain_declaration(job.result, before, str(since))
        write_file(declare, text.encode())
        print(text.splitlines()[-1])


def _print(report: SelfTestReport) -> None:
    """Gain and isolation by coil."""
    from rich.console import Console
    from rich.table import Table

    table = Table(title=f"self-test passed, tones of {report.frequency_hz:.0f} Hz", title_justify="left")
    for heading in ("coil", "gain / expected", "isolation / dB"):
        table.add_column(heading, justify="right")
    for coil, gain in report.gain.items():
        table.add_row(coil, f"{gain:.3f}", f"{report.isolation_db[coil]:.1f}")
    Console(width=120).print(table)
