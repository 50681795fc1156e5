"""The command line: `platform-daemon serve | measure | fit | harmonics | slide | diagnose | plot | ...`.

Exit codes: 0 done; 1 a device or the program failed; 2 bad input, or a device is not what the platform file says;
3 nothing to fit or diagnose; 130 interrupted.
"""

from __future__ import annotations

import logging
import socket
import sys
from pathlib import Path
from typing import Annotated, Any

import structlog
import typer
from rich.console import Console

from drivers.errors import InputError, PlatformError
from drivers.validation import validated
from platform_daemon import __version__
from platform_daemon.reports import fit_table_text, print_info

from .bench import bench_app
from .calibrate import calibrate_app
from .devices import devices, reset_amplifier
from .diagnose import diagnose
from .diagnose_live import FilesOrLive
from .emulate import emulate
from .fit import fit
from .harmonics import harmonics
from .interrupts import INTERRUPTED, heed_one_interrupt, no_interrupt_lost
from .models import adopt, models_app
from .options import (
    CalibrationOption,
    EndpointsOption,
    ForceOption,
    JsonOption,
    ModelsOption,
    PlatformOption,
    SetOption,
    TermOption,
    VariantOption,
    WindowOption,
    library,
    progress_bar,
    variant_named,
)
from .output import must_not_exist, write_json
from .precision import predict
from .sliding import slide

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False, help=__doc__)
config_app = typer.Typer(help="Configuration files.")
app.add_typer(config_app, name="config")
app.add_typer(bench_app, name="bench")
app.add_typer(calibrate_app, name="calibrate")
app.add_typer(models_app, name="models")
app.command()(adopt)
app.command()(devices)
app.command()(reset_amplifier)
app.command()(emulate)
app.command()(fit)
app.command()(harmonics)
app.command()(predict)
app.command()(slide)
app.command(cls=FilesOrLive)(diagnose)


def main() -> None:
    """Entry point; every expected error is one line on stderr."""
    _log_from(logging.WARNING)
    try:
        with no_interrupt_lost():
            code = app(standalone_mode=False)
        sys.exit(code)
    except typer.TyperException as error:
        message = " ".join(getattr(error, "format_message", error.__str__)().split()).rstrip(".")
        print(f"error: {message}. Remedy: see platform-daemon --help.", file=sys.stderr)
        sys.exit(2)
    except PlatformError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2 if error.nothing_moved else 1)
    except OSError as error:
        print(f"error: {error.filename or ''}: {error.strerror or error}", file=sys.stderr)
        sys.exit(1)
    except (KeyboardInterrupt, typer.Abort):
        print("interrupted; outputs are off", file=sys.stderr)
        sys.exit(INTERRUPTED)


def _log_from(level: int) -> None:
    """Log events of at least this level, one per line, on stderr."""
    structlog.configure(
        processors=[
            structlog.processors.add_log_level,
            structlog.processors.TimeStamper(fmt="iso"),
            structlog.processors.format_exc_info,
            structlog.processors.KeyValueRenderer(key_order=["timestamp", "level", "event"]),
        ],
        wrapper_class=structlog.make_filtering_bound_logger(level),
        logger_factory=structlog.PrintLoggerFactory(sys.stderr),
    )


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


@app.command()
def serve(
    platform: PlatformOption = "simulated",
    host: Annotated[str, typer.Option(help="Address to listen on.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Port to listen on; 0: any free one.", min=0, max=65535)] = 8212,
    data: Annotated[Path, typer.Option(help="Folder of recordings and fits.")] = Path("data"),
    overrides: SetOption = None,
    endpoints: EndpointsOption = None,
) -> None:
    """Run the daemon until SIGTERM or Ctrl-C; outputs go off first."""
    from platform_daemon.api import Server, create_api
    from platform_daemon.app import create_context, open_data_folder, start_engine
    from platform_daemon.engine import JobRecords
    from platform_daemon.settings import load_platform

    _log_from(logging.INFO)
    file = load_platform(platform, overrides or (), endpoints)
    listener = _listen(host, port)
    folder = open_data_folder(data)
    # uvicorn raises the signal again when it has ended; it must then not kill us before the series is put together.
    heed_one_interrupt()
    engine = start_engine(file, JobRecords(folder.jobs), library(folder.models))
    try:
        server = Server(create_api(create_context(engine, folder)), engine, host, port)
        print(f"listening on http://{host}:{listener.getsockname()[1]}", flush=True)
        server.run(sockets=[listener])
    except KeyboardInterrupt:
        pass
    finally:
        engine.close()


def _listen(host: str, port: int) -> socket.socket:
    try:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        listener = socket.socket(family, socket.SOCK_STREAM)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((host, port))
        listener.listen(128)
    except OSError as error:
        why = error.strerror or str(error)
        raise InputError("cannot listen", where=f"{host}:{port}", why=why, remedy="choose another --port") from None
    return listener


@app.command()
def measure(
    resonator: Annotated[str, typer.Option(help="thread, jewel, or a resonator file.")],
    out: Annotated[Path, typer.Option(help="Recording to write.")],
    shots: Annotated[int, typer.Option(min=0, help="Excited shots.")] = 1,
    blank_shots: Annotated[int, typer.Option(min=0, help="Shots without excitation before them.")] = 0,
    sequence: Annotated[str | None, typer.Option(help="Sequence file; default: the resonator's preset.")] = None,
    field_ut: Annotated[float | None, typer.Option(help="Excitation field, uT; default: the preset's.")] = None,
    rx_s: Annotated[float | None, typer.Option(help="RX window, s; default: the preset's.")] = None,
    window: WindowOption = "d30",
    variant: Annotated[str | None, typer.Option(help="Model of the on-line fits; default: the resonator's.")] = None,
    models: ModelsOption = None,
    sample: Annotated[str, typer.Option(help="Sample name for the record.")] = "",
    operator: Annotated[str, typer.Option(help="Operator for the record.")] = "",
    comment: Annotated[str, typer.Option(help="Comment for the record.")] = "",
    platform: PlatformOption = "simulated",
    overrides: SetOption = None,
    endpoints: EndpointsOption = None,
    json_file: JsonOption = None,
    force: ForceOption = False,
) -> None:
    """Measure a series of shots and fit each; every shot is on disk before it counts."""
    from platform_daemon.analysis import parse_window
    from platform_daemon.app import start_engine
    from platform_daemon.engine import AcquisitionRequest
    from platform_daemon.settings import load_platform, load_sequence

    changed: dict[str, Any] = {"field_t": None if field_ut is None else field_ut * 1e-6, "rx_s": rx_s}
    base = {} if sequence is None else load_sequence(sequence).model_dump(exclude={"repetitions", "blank_shots"})
    asked = {
        "resonator": resonator,
        "shots": shots,
        "blank_shots": blank_shots,
        "sequence": base | {k: v for k, v in changed.items() if v is not None},
        "window": parse_window(window),
        "variant": variant,
        "sample": sample,
        "operator": operator,
        "comment": comment,
    }
    request = validated(AcquisitionRequest, asked, "measure")
    must_not_exist(json_file, force)
    must_not_exist(out, force)
    heed_one_interrupt()
    engine = start_engine(load_platform(platform, overrides or (), endpoints), models=library(models))
    interrupted = False
    try:
        _prepare_fit()
        job = engine.acquire(engine.plan(request), out, out.parent, overwrite=force)
        try:
            _watch(job)
        except KeyboardInterrupt:
            interrupted = True
            engine.outputs_off()
            job.ended.wait(timeout=60)
    finally:
        engine.close()
    _report_series(job, out, json_file)
    if interrupted:
        print("interrupted; outputs are off", file=sys.stderr)
        raise typer.Exit(INTERRUPTED)
    if job.error is not None:
        raise job.error


def _report_series(job: Any, out: Path, json_file: Path | None) -> None:
    """What came out of a series, also of one that was cut short."""
    for warning in job.warnings:
        print(f"warning: {warning}", file=sys.stderr)
    if "fit" in job.result:
        print(fit_table_text(job.result["fit"]))
    print(f"{job.result.get('shots', 0)} of {int(job.total)} shots" + (f" in {out}" if job.result else ""))
    if job.result:
        write_json(json_file, {"file": str(out), **job.result})


def _prepare_fit() -> None:
    """Before the first shot: kernels that are compiled or loaded meanwhile would lengthen the time between shots."""
    from platform_daemon.estimation import warm_up

    try:
        with Console(stderr=True).status("preparing the fit (half a minute the first time)"):
            warm_up()
    except KeyboardInterrupt:
        print("interrupted; outputs are off", file=sys.stderr)
        raise typer.Exit(INTERRUPTED) from None


def _watch(job: Any) -> None:
    """A progress bar until the job has ended."""
    with progress_bar() as bar:
        task = bar.add_task("waiting", total=job.total, unit=job.unit)
        while not job.ended.wait(timeout=0.1):
            now = job.progress()
            bar.update(task, completed=now.done, description=now.phase)


@app.command()
def info(file: Path, json_file: JsonOption = None, force: ForceOption = False) -> None:
    """Say what a recording holds."""
    from platform_daemon.store import describe, open_recording

    facts = describe(open_recording(file))
    must_not_exist(json_file, force)
    print_info(facts)
    write_json(json_file, facts)


@app.command()
def plot(
    file: Path,
    frame: Annotated[int, typer.Option(min=0, help="Frame, from 0.")] = 0,
    png: Annotated[Path | None, typer.Option(help="PNG to write; default: beside the recording.")] = None,
    variant: VariantOption = None,
    term: TermOption = None,
    models: ModelsOption = None,
    window: WindowOption = "d30",
    calibration: CalibrationOption = None,
    force: ForceOption = False,
) -> None:
    """Draw dm/dt with the fit over it, the residual and the spectrum."""
    from platform_daemon.analysis import parse_window, ring_down_plot_data
    from platform_daemon.reports import save_png
    from platform_daemon.store import open_recording, read_calibration

    recording = open_recording(file)
    if calibration is not None:
        recording = recording.with_calibration(read_calibration(calibration), str(calibration))
    target = png or file.with_name(f"{file.name.removesuffix('.h5').removesuffix('.mmr')}-frame{frame}.png")
    must_not_exist(target, force)
    save_png(
        ring_down_plot_data(recording, frame, variant_named(variant, models), parse_window(window), term or ()), target
    )
    print(target)


@config_app.command("check")
def config_check(file: Path, endpoints: EndpointsOption = None) -> None:
    """Check a platform, resonator or sequence file; a platform's devices are built, not energised."""
    from platform_daemon.app import check_config

    print(check_config(file, endpoints))
