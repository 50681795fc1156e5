"""The demo: starts the real server on the simulated platform, measures both resonators through REST, fits them, and
shows each fit next to the simulated truth and the paper.  Writes demo/*.h5 and demo/*.png."""

from __future__ import annotations

import math
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import httpx2
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from platform_daemon.cli_tables import COLUMNS, number
from platform_daemon.store import read_truth

HERE = Path(__file__).resolve().parent
COMMAND = Path(sys.executable).with_name("platform-daemon")
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


def start_server(data: Path, log: Any) -> tuple[subprocess.Popen[str], str]:
    """The daemon as a process of its own, and its address."""
    arguments = [str(COMMAND), "serve", "--port", "0", "--data", str(data)]
    server = subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=log, text=True)
    assert server.stdout is not None
    line = server.stdout.readline()
    if not line.startswith("listening on "):
        raise SystemExit(f"the server did not start, see {log.name}")
    return server, line.removeprefix("listening on ").strip()


def wait_until_ready(client: httpx2.Client) -> None:
    """The first start on a machine compiles the estimator; the server already answers meanwhile."""
    with console.status("compiling the estimator (first start only) ..."):
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


def show(resonator: str, job: dict[str, Any], recording: Path) -> None:
    """Fit, truth and paper side by side."""
    truths = read_truth(recording)
    assert truths is not None
    table = Table(title=f"{resonator}, window d30, {SHOTS} shots", title_justify="left")
    for heading in ("shot", "parameter", "fit (std)", "simulated truth", "(fit - truth) / std", "paper (scatter)"):
        table.add_column(heading, justify="right")
    for frame, truth in zip(job["result"]["fit"]["frames"], truths, strict=True):
        add_rows(table, frame, next(iter(truth.values())), PAPER[resonator])
    console.print(table)


def add_rows(table: Table, frame: dict[str, Any], truth: dict[str, Any], paper: dict[str, tuple[float, float]]) -> None:
    """The rows of one shot."""
    if frame["verdict"] != "good":
        table.add_row(str(frame["frame"]), "refused", frame["reason"])
        return
    for name, heading, factor in COLUMNS:
        if name in frame["parameters"]:
            found = frame["parameters"][name]
            pull = (found["value"] - truth[name]) / found["std"]
            shown = number(found["value"], found["std"], factor)
            decimals = len(shown.partition("(")[0].partition(".")[2])
            cells = (shown, f"{truth[name] * factor:.{decimals}f}", f"{pull:+.2f}")
            table.add_row(str(frame["frame"]), heading, *cells, number(*paper[name], factor))
    table.add_section()


def main() -> None:
    """Run the demo; the server is stopped by SIGTERM whatever happens."""
    started = time.monotonic()
    data = HERE / "data"
    shutil.rmtree(data, ignore_errors=True)
    with (HERE / "server.log").open("w") as log:
        server, address = start_server(data, log)
        try:
            console.print(f"server at {address}, its page of interactive documentation at {address}/docs")
            with httpx2.Client(base_url=address, timeout=60) as client:
                wait_until_ready(client)
                for resonator in ("jewel", "thread"):
                    job = measure(client, resonator)
                    show(resonator, job, keep(client, job, resonator))
        finally:
            server.send_signal(signal.SIGTERM)
            code = server.wait(timeout=30)
    shutil.rmtree(data, ignore_errors=True)
    files = ", ".join(sorted(os.path.relpath(p) for p in (*HERE.glob("*.h5"), *HERE.glob("*.png"))))
    console.print(f"wrote {files}; server stopped with code {code}; {time.monotonic() - started:.0f} s in all")


if __name__ == "__main__":
    main()
