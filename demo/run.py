"""The demo: starts the real server on the simulated platform, measures both resonators through REST, fits them, and
shows each fit next to the simulated truth and the paper.  Writes demo/*.h5 and demo/*.png, among them a picture of the
operator's page where a Chromium is installed.

With --emulated the platform is the emulated lab: two I/O cards by TCP, switch and LNA on serial lines, amplifier by
USB.  What drives it cannot know the truth then, which stays with the emulator."""

from __future__ import annotations

import json
import math
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
import tomllib
from pathlib import Path
from typing import Any

import httpx2
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from platform_daemon.core.recordings.truth import read_truth
from platform_daemon.core.reporting.numbers import number
from platform_daemon.core.schemas.parameters import PARAMETERS, RODRIGUES
from platform_daemon.core.settings import locate

HERE = Path(__file__).resolve().parent
COMMAND = Path(sys.executable).with_name("platform-daemon")
ENDPOINTS = HERE / "endpoints.json"
SHOTS = 3

# Paper, tab:model_params_fit_result, D30: mean and empirical standard deviation over 100 sequences.
PAPER = {
    "thread": {
        "f_nat_hz": (215.69, 0.08),
        "m_r_am2": (11.014e-3, 0.004e-3),
        "lambda_per_s": (0.2465, 0.0010),
        "phi_max_rad": (math.radians(22.8), math.radians(0.4)),
        "psi_start_rad": (math.radians(335.7), math.radians(1.2)),
    },
    "jewel": {
        "f_nat_hz": (213.25, 0.19),
        "m_r_am2": (12.028e-3, 0.143e-3),
        "lambda_per_s": (0.0978, 0.1211),
        "tf_over_i_rad_per_s2": (1324.0, 353.0),
        "phi_max_rad": (math.radians(53.0), math.radians(0.6)),
        "psi_start_rad": (math.radians(219.2), math.radians(4.9)),
    },
}
console = Console(width=120)


def start_emulator(log: Any) -> subprocess.Popen[str]:
    """The emulated lab as a process of its own; ENDPOINTS says where it listens."""
    ENDPOINTS.unlink(missing_ok=True)
    emulator = subprocess.Popen([str(COMMAND), "emulate", "--json", str(ENDPOINTS)], stdout=log, stderr=log, text=True)
    while not ENDPOINTS.exists():
        if emulator.poll() is not None:
            raise SystemExit(f"the emulator did not start, see {log.name}")
        time.sleep(0.05)
    return emulator


def put_in(resonator: str) -> None:
    """Put a resonator into the emulated clamping unit, as an operator does."""
    at = json.loads(ENDPOINTS.read_text())["control"]
    tables = tomllib.loads(locate("resonators", resonator).read_text())
    with socket.create_connection((at["host"], at["port"]), 10) as link, link.makefile("rwb") as stream:
        stream.write(json.dumps({"do": "mount", "specimen": tables}).encode() + b"\n")
        stream.flush()
        answer = json.loads(stream.readline())
    if not answer["ok"]:
        raise SystemExit(f"{resonator} cannot be mounted: {answer['error']}")


def start_server(data: Path, log: Any, *options: str) -> tuple[subprocess.Popen[str], str]:
    """The daemon as a process of its own, and its address."""
    arguments = [str(COMMAND), "serve", "--port", "0", "--data", str(data), *options]
    server = subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=log, text=True)
    assert server.stdout is not None
    line = server.stdout.readline()
    if not line.startswith("listening on "):
        raise SystemExit(f"the server did not start, see {log.name}")
    return server, line.removeprefix("listening on ").strip()


def wait_until_ready(client: httpx2.Client) -> None:
    """The estimator is loaded, or compiled where it never was; the server already answers meanwhile."""
    with console.status("loading the estimator (compiling it, where `make install` has not) ..."):
        while client.get("/ready").status_code != 200:
            time.sleep(0.2)


def measure(client: httpx2.Client, resonator: str) -> dict[str, Any]:
    """One acquisition job from request to result, with its progress shown."""
    body = {"resonator": resonator, "shots": SHOTS, "operator": "demo", "comment": "make demo"}
    answer = client.post("/acquisitions", json=body)
    answer.raise_for_status()
    where = answer.headers["Location"]
    columns = (TextColumn("{task.description:<28}"), BarColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(resonator, total=1.0)
        while True:
            job: dict[str, Any] = client.get(where).json()
            progress = job["progress"]
            bar.update(task, completed=progress["fraction"], description=f"{resonator}: {progress['phase']}")
            if job["state"] in ("done", "failed", "cancelled"):
                break
            time.sleep(0.1)
    if job["state"] != "done":
        raise SystemExit(f"{resonator}: {job['state']}: {job['error']}")
    return job


def keep(client: httpx2.Client, job: dict[str, Any], resonator: str) -> Path:
    """Download the recording and draw its first frame."""
    target = HERE / f"{resonator}.h5"
    with client.stream("GET", f"/recordings/{job['result']['recording']}/file") as answer, target.open("wb") as file:
        for block in answer.iter_bytes():
            file.write(block)
    picture = target.with_suffix(".png")
    subprocess.run([COMMAND, "plot", target, "--png", picture, "--force"], check=True, stdout=subprocess.DEVNULL)
    return target


def keep_picture_of_page(address: str) -> None:
    """Draw the newest shot as the operator's page shows it."""
    browser = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if browser is None:
        console.print("no picture of the operator's page: no browser was found (Debian's is in the package chromium)")
        return
    from playwright.sync_api import Error, sync_playwright

    arguments = ["--no-sandbox"] if os.geteuid() == 0 else []  # Chromium refuses to run as root with its sandbox
    try:
        with sync_playwright() as playwright, console.status("drawing the operator's page ..."):
            chromium = playwright.chromium.launch(executable_path=browser, args=arguments)
            page = chromium.new_page(viewport={"width": 1200, "height": 860})
            page.goto(f"{address}/page/#/shot")
            page.get_by_text("Table: Spectrum").wait_for()
            page.screenshot(path=HERE / "page.png", full_page=True)
            chromium.close()
    except Error as error:
        console.print(f"no picture of the operator's page: {browser} failed: {error.message.splitlines()[0]}")


def show(resonator: str, job: dict[str, Any], recording: Path) -> None:
    """Fit, truth and paper side by side."""
    frames = job["result"]["fit"]["frames"]
    truths = [next(iter(truth.values())) for truth in read_truth(recording) or []] or [None] * len(frames)
    table = Table(title=f"{resonator}, window d30, {SHOTS} shots", title_justify="left")
    for heading in ("shot", "parameter", "fit (std)", "simulated truth", "(fit - truth) / std", "paper (scatter)"):
        table.add_column(heading, justify="right")
    for frame, truth in zip(frames, truths, strict=True):
        add_rows(table, frame, truth, PAPER[resonator])
    console.print(table)


def add_rows(
    table: Table, frame: dict[str, Any], truth: dict[str, Any] | None, paper: dict[str, tuple[float, float]]
) -> None:
    """The rows of one shot; truth None: nobody here knows it."""
    if frame["verdict"] != "good":
        table.add_row(str(frame["frame"]), "refused", frame["reason"])
        return
    for name, parameter in PARAMETERS.items():
        if name in frame["parameters"] and name not in RODRIGUES:
            found, factor = frame["parameters"][name], parameter.display_factor
            shown = number(found["value"], found["std"], factor)
            decimals = len(shown.partition("(")[0].partition(".")[2])
            cells = (shown, "-", "-")
            if truth is not None:
                pull = (found["value"] - truth[name]) / found["std"]
                cells = (shown, f"{truth[name] * factor:.{decimals}f}", f"{pull:+.2f}")
            table.add_row(str(frame["frame"]), parameter.heading, *cells, number(*paper[name], factor))
    table.add_section()


def stop(process: subprocess.Popen[str] | None) -> int | None:
    """SIGTERM; the exit code."""
    if process is None:
        return None
    process.send_signal(signal.SIGTERM)
    return process.wait(timeout=30)


def main() -> None:
    """Run the demo; server and emulator are stopped by SIGTERM whatever happens."""
    emulated, started = "--emulated" in sys.argv[1:], time.monotonic()
    data = HERE / "data"
    shutil.rmtree(data, ignore_errors=True)
    with (HERE / "server.log").open("w") as log:
        emulator = start_emulator(log) if emulated else None
        try:
            options = ("--platform", "emulated", "--endpoints", str(ENDPOINTS)) if emulated else ()
            server, address = start_server(data, log, *options)
        except BaseException:
            stop(emulator)
            raise
        try:
            console.print(
                f"server at {address}, the operator's page at {address}/page/, REST documentation at {address}/docs"
            )
            with httpx2.Client(base_url=address, timeout=60) as client:
                wait_until_ready(client)
                for resonator in ("jewel", "thread"):
                    if emulated:
                        put_in(resonator)
                    job = measure(client, resonator)
                    show(resonator, job, keep(client, job, resonator))
                keep_picture_of_page(address)
        finally:
            code = stop(server)
            stop(emulator)
    shutil.rmtree(data, ignore_errors=True)
    files = ", ".join(sorted(os.path.relpath(p) for p in (*HERE.glob("*.h5"), *HERE.glob("*.png"))))
    console.print(f"wrote {files}; server stopped with code {code}; {time.monotonic() - started:.0f} s in all")


if __name__ == "__main__":
    main()
