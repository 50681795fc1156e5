"""Attacks the REST interface of a daemon on the simulated platform with schemathesis: examples, boundaries, random
requests, and walks from answer to answer along the links of the schema.

`python -m tests.campaigns.attack_api --cases 100` draws so many requests for each operation; exit code 1: findings.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import tempfile
import threading
from collections.abc import Sequence
from pathlib import Path

import httpx2

from platform_daemon.core.web.context import EXAMPLE_RECORDING
from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.command_line import wait_for
from tests.kit.daemon_process import daemon
from tests.kit.data import DATA
from tests.kit.rest import finished, pages

CONFIG = Path(__file__).parents[1] / "core/web/schemathesis.toml"
PROGRAM = Path(sys.executable).with_name("schemathesis")
PATIENCE_S = 1.0  # a job may run so long, so that no series of a million shots keeps the others from their turn


def attack(folder: Path, *runs: Sequence[str]) -> list[subprocess.CompletedProcess[str]]:
    """Attack a daemon whose data are in `folder`, once with the options of each run; what schemathesis says."""
    with daemon(folder / "data") as address, httpx2.Client(base_url=address, timeout=60) as client:
        # Whoever attacks waits ten seconds for an answer; what is loaded once may take longer on a busy computer.
        wait_for(lambda: client.get("/ready").status_code == 200, 120)
        client.post("/predict", json={"resonator": "jewel"})
        client.get("/openapi.json")
        _prepare(client, folder / "data/recordings")
        ended = threading.Event()
        thread = threading.Thread(target=_cancel_all, args=(client, ended), daemon=True)
        thread.start()
        command = [PROGRAM, "--config-file", CONFIG, "run", f"{address}/openapi.json", "--continue-on-failure"]
        try:
            return [
                subprocess.run([*command, *options], capture_output=True, text=True, cwd=folder, check=False)
                for options in runs
            ]
        finally:
            ended.set()
            thread.join()


def _prepare(client: httpx2.Client, recordings: Path) -> None:
    """Recordings of the names that the examples of the schema have, and others that cannot be used."""
    job = finished(client, client.post("/acquisitions", json={**SHORT_JEWEL, "shots": 2}).headers["location"])
    for name in (EXAMPLE_RECORDING, "a", "b"):
        shutil.copy(recordings / job["result"]["file"], recordings / f"{name}.h5")
    shutil.copy(DATA / "measured/r2_rotary_pendulum_run1.h5", recordings)
    client.post("/sequences", params={"name": "short"}, json={"rx_s": 0.6})
    (recordings / "broken.h5").write_bytes(b"no hdf5")


def _cancel_all(client: httpx2.Client, ended: threading.Event) -> None:
    while not ended.wait(PATIENCE_S):
        for kind in ("procedures", "acquisitions", "calibrations", "fits", "diagnoses"):
            for job in (job for page in pages(client, f"/{kind}", 1000) for job in page["items"]):
                if job["state"] in ("queued", "running"):
                    client.delete(job["links"]["self"])


def main() -> int:
    """0: nothing was found."""
    parser = argparse.ArgumentParser(prog="python -m tests.campaigns.attack_api", description=__doc__)
    parser.add_argument("--cases", type=int, default=100, help="random requests per operation")
    parser.add_argument("--seed", type=int, help="of an attack that is to be repeated")
    parser.add_argument("--only", help="operations whose path matches this regular expression")
    asked = parser.parse_args()
    options = ["--max-examples", str(asked.cases)]
    options += [] if asked.seed is None else ["--seed", str(asked.seed)]
    options += [] if asked.only is None else ["--include-path-regex", asked.only]
    with tempfile.TemporaryDirectory() as folder:
        (done,) = attack(Path(folder), options)
    print(done.stdout, done.stderr)
    return done.returncode


if __name__ == "__main__":
    sys.exit(main())
