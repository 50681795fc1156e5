"""`platform-daemon bench fit`: kept for those who call it; the benchmarks are part of a checkout (`make bench`)."""

from __future__ import annotations

import importlib
import sys
from importlib.util import find_spec
from pathlib import Path

import typer

from drivers.errors import InputError

PROGRAM = "tests.benchmarks"
CHECKOUT = Path(__file__).parents[2]

bench_app = typer.Typer(help="Benchmarks; compare ratios, not milliseconds.")


@bench_app.callback()
def _group() -> None:
    """Benchmarks; compare ratios, not milliseconds."""


@bench_app.command(
    "fit", context_settings={"allow_extra_args": True, "ignore_unknown_options": True}, add_help_option=False
)
def bench_fit(context: typer.Context) -> None:
    """Time the fit of the paper's four datasets: `python -m tests.benchmarks` of the checkout that is installed."""
    sys.path.insert(0, str(CHECKOUT))
    if find_spec("tests") is None or find_spec(PROGRAM) is None:
        raise InputError("there are no benchmarks here", where=str(CHECKOUT), remedy="run `make bench` in a checkout")
    importlib.import_module(f"{PROGRAM}.__main__").app(context.args, standalone_mode=False)
