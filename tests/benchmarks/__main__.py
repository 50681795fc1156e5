"""`make bench`: times against a floor and against the paper's method, in one run; compare ratios, not milliseconds."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from platform_daemon.core.command_line.output import must_not_exist
from platform_daemon.core.state.durable import write_file
from platform_daemon.features.fit.batch.executors import cores
from tests.benchmarks.campaign import campaign_text, run_campaign
from tests.benchmarks.fits import run_bench, table
from tests.benchmarks.process import processes_text, run_processes
from tests.benchmarks.solvers import run_solvers, solvers_text

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)


@app.command()
def bench(
    repeats: Annotated[int, typer.Option(min=3, help="Fits per dataset.")] = 25,
    paper_s: Annotated[float, typer.Option(min=0.0, help="Time box of the paper's method; 0: none.")] = 20.0,
    shots: Annotated[int, typer.Option(min=0, help="Shots per dataset of the campaign; 0: none.")] = 100,
    processes: Annotated[
        bool, typer.Option(help="First fit cold and warm, memory and growth with the record: a minute more.")
    ] = True,
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the result as JSON.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite files that exist.")] = False,
) -> None:
    """Time the fit of the paper's four datasets, beside a demodulation floor and the paper's method.

    Then the same fit by diffrax and by CasADi, if they are installed, the campaign of 400 fits, the first fit of a
    fresh process with and without compiled kernels, the memory of a fit over its record's size, and its time at one,
    two and four times the samples of TD30.
    """
    must_not_exist(json_file, force)
    report = run_bench(repeats=repeats, paper_seconds=paper_s)
    print(table(report))
    report["solvers"] = run_solvers()
    print(solvers_text(report["solvers"], report["datasets"]["TN50"]["fit_ms"]))
    if shots > 0:
        report["campaign"] = run_campaign(shots, min(2, cores()))
        print(campaign_text(report["campaign"]))
    if processes:
        report |= run_processes()
        print(processes_text(report))
    if json_file is not None:
        write_file(json_file, json.dumps(report, indent=1, allow_nan=False).encode())


if __name__ == "__main__":
    app()
