"""`make peers`: every tool on every dataset, with one thread; writes docs/evidence/peers.md.

python -m tests.benchmarks.peers --only r1 --routes "viscous floor,ours" --journal peers.jsonl
"""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Annotated, Any

import typer

from tests.kit.data import ROOT

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def one_thread() -> None:
    """Before anything that counts cores is loaded: one core, for this process and those it starts."""
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    os.environ |= dict.fromkeys(_THREADS, "1")
    os.environ["JAX_PLATFORMS"] = "cpu"


@app.command()
def peers(
    only: Annotated[str, typer.Option(help="Datasets, with commas; default: all.")] = "",
    chosen: Annotated[str, typer.Option("--routes", help="Rows, with commas; default: all.")] = "",
    shots: Annotated[int, typer.Option(min=0, help="Simulated shots.")] = 20,
    journal: Annotated[Path, typer.Option(help="Finished rows, which are not run again.")] = Path("peers.jsonl"),
    page: Annotated[Path, typer.Option(help="The page that is written.")] = ROOT / "docs" / "evidence" / "peers.md",
) -> None:
    """Run what the journal does not hold, then write the page."""
    one_thread()
    from tests.benchmarks.peers.datasets import Task, measured
    from tests.benchmarks.peers.page import document
    from tests.benchmarks.peers.routes import SHOT_BOXES, TRUE, Boxes, Row, measure, routes
    from tests.benchmarks.peers.simulated import simulated

    def row(line: str) -> Row:
        held: dict[str, Any] = {n: tuple(v) if isinstance(v, list) else v for n, v in json.loads(line).items()}
        return Row(**held)

    done = [row(line) for line in journal.read_text("utf-8").splitlines()] if journal.exists() else []
    angles = measured()
    names = [n for n in (*angles, *(f"s{k:02d}" for k in range(shots))) if not only or n in only.split(",")]
    for name in names:
        task: Task | None = angles.get(name)
        for route in routes(Boxes() if name in angles else SHOT_BOXES):
            if (
                (name in angles and route.name == TRUE)
                or (chosen and route.name not in chosen.split(","))
                or any((r.route, r.dataset) == (route.name, name) for r in done)
            ):
                continue
            task = simulated(int(name[1:])) if task is None else task
            done.append(measure(route, task))
            with journal.open("a", encoding="utf-8") as file:
                file.write(json.dumps(done[-1].as_json()) + "\n")
            error = done[-1].held_out
            text = "-" if error is None else "diverges" if math.isinf(error) else f"{error:.4f}"
            print(f"{name} {route.name}: {text}, {', '.join(done[-1].named)} ({done[-1].seconds:.1f} s)", flush=True)
    page.write_text(document(done), encoding="utf-8")


if __name__ == "__main__":
    app()
