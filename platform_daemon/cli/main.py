"""The command line: `platform-daemon serve | measure | sweep | characterise | fit | harmonics | diagnose | ...`.

Exit codes: 0 done; 1 a device or the program failed; 2 bad input, or a device is not what the platform file says;
3 nothing to fit or diagnose; 130 interrupted.
"""

from __future__ import annotations

import logging
import sys
from typing import Annotated

import typer

from drivers.errors import PlatformError
from platform_daemon import __version__
from platform_daemon.serving import log_from

from .bench import bench_app
from .calibrate import calibrate_app
from .characterise import characterise
from .design import defects, design
from .devices import config_app, devices, reset_amplifier
from .diagnose import diagnose
from .diagnose_live import FilesOrLive
from .doctor import doctor
from .emulate import emulate
from .fit import fit
from .harmonics import harmonics
from .interrupts import INTERRUPTED, no_interrupt_lost
from .measure import measure
from .models import adopt, models_app
from .precision import predict
from .ramp import ramp
from .recordings import info, plot
from .retention import retention
from .safety import outputs_off, reset_fault
from .schedule import schedule_app
from .self_test import self_test
from .serve import serve
from .sliding import slide
from .sweep import sweep
from .terminal import plain_text_only
from .tokens import token_app
from .trend import index_app, trend
from .tune import tune

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False, help=__doc__)
app.add_typer(config_app, name="config")
app.add_typer(bench_app, name="bench")
app.add_typer(calibrate_app, name="calibrate")
app.add_typer(models_app, name="models")
app.add_typer(token_app, name="token")
app.add_typer(schedule_app, name="schedule")
app.add_typer(index_app, name="index")
app.command()(adopt)
app.command()(devices)
app.command()(reset_amplifier)
app.command()(outputs_off)
app.command()(reset_fault)
app.command()(doctor)
app.command()(self_test)
app.command()(emulate)
app.command()(fit)
app.command()(harmonics)
app.command()(predict)
app.command()(design)
app.command()(defects)
app.command()(slide)
app.command(cls=FilesOrLive)(diagnose)
app.command()(characterise)
app.command()(serve)
app.command()(measure)
app.command()(sweep)
app.command()(ramp)
app.command()(tune)
app.command()(info)
app.command()(plot)
app.command()(trend)
app.command()(retention)


def main() -> None:
    """Entry point; every expected error is one line on stderr."""
    log_from(logging.WARNING)
    with plain_text_only():
        sys.exit(_run())


def _run() -> int | None:
    """The exit code."""
    try:
        with no_interrupt_lost():
            code: int | None = app(standalone_mode=False)
        if code == INTERRUPTED:  # so ends a command that was interrupted anywhere, without a word
            print("interrupted; outputs are off", file=sys.stderr)
        return code
    except typer.TyperException as error:
        message = " ".join(getattr(error, "format_message", error.__str__)().split()).rstrip(".")
        print(f"error: {message}. Remedy: see platform-daemon --help.", file=sys.stderr)
        return 2
    except PlatformError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2 if error.nothing_moved else 1
    except OSError as error:
        print(f"error: {error.filename or ''}: {error.strerror or error}", file=sys.stderr)
        return 1
    except (KeyboardInterrupt, typer.Abort):
        print("interrupted; outputs are off", file=sys.stderr)
        return INTERRUPTED


@app.callback(invoke_without_command=True)
def _root(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version and stop.")] = False,
) -> None:
    """Run the 3D Helmholtz-coil platform that reads magneto-mechanical resonators.

    Exit codes: 0 done; 1 a device or the program failed; 2 bad input, or a device is not what the platform file says;
    3 nothing to fit or diagnose; 130 interrupted.
    """
    if version:
        print(__version__)
        raise typer.Exit
    if context.invoked_subcommand is None:
        print(context.get_help())
        raise typer.Exit(2)
