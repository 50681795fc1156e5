"""Every scenario by its name, and how all of them are run."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tests.system.golden import cli_bad, cli_design, cli_diagnoses, cli_fits, cli_platform, rest, rest_faults
from tests.system.golden.workplace import TREE, Workplace

SCENARIOS: dict[str, Callable[[Workplace], None]] = {
    "cli-fits": cli_fits.fits,
    "cli-windows": cli_fits.windows,
    "cli-design": cli_design.design,
    "cli-series": cli_platform.series,
    "cli-platform": cli_platform.platform,
    "cli-emulated": cli_platform.emulated,
    "cli-diagnoses": cli_diagnoses.diagnoses,
    "cli-live": cli_diagnoses.live,
    "cli-bad": cli_bad.bad_input,
    "rest": rest.routes,
    "rest-faults": rest_faults.faults,
}


def make(target: Path, names: Iterable[str] = SCENARIOS, tree: Path = TREE, at_once: int = 1) -> None:
    """Run scenarios on the program of a tree, so many at once, and keep what they tell, a folder each."""
    with ThreadPoolExecutor(at_once) as pool:
        for _ in pool.map(lambda name: _made(target / name, name, tree), names):
            pass


def _made(target: Path, name: str, tree: Path) -> None:
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="golden-") as folder:
        SCENARIOS[name](Workplace(Path(folder) / "work", target, tree))
    print(f"{name}: {time.monotonic() - began:.1f} s", flush=True)
