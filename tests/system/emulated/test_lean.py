"""The process that owns the hardware, on the emulated wires: what it loads, and what its fit worker's death does."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys

import pytest

from platform_daemon.core.jobs.workers.limits import WorkerLimits
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.features.acquire.destination import OwnFile
from platform_daemon.features.acquire.series_plan import plan_series, series_work
from platform_daemon.processes.assembly import hardware_workers, start_engine
from tests.kit.command_line import wait_for

REQUEST = {"resonator": "jewel", "shots": 3, "sequence": {"rx_s": 0.6, "pause_s": 0.2}}
SERIES = """
import json, sys
from pathlib import Path

if __name__ == "__main__":
    import platform_daemon.processes.hardware_process
    from platform_daemon.processes.assembly import hardware_workers, start_engine
    from platform_daemon.core.jobs.workers.limits import WorkerLimits
    from platform_daemon.core.schemas.requests import AcquisitionRequest
    from platform_daemon.core.settings import load_platform
    from platform_daemon.features.acquire.destination import OwnFile
    from platform_daemon.features.acquire.series_plan import plan_series, series_work

    endpoints, folder, request = sys.argv[1:]
    online, computing = hardware_workers(WorkerLimits())
    engine = start_engine(load_platform("emulated", (), Path(endpoints)), online=online, computing=computing)
    plan = plan_series(engine, AcquisitionRequest.model_validate_json(request))
    job = engine.submit(series_work(engine, plan, OwnFile(None, Path(folder))))
    job.ended.wait(120)
    heavy = ("numba", "llvmlite", "matplotlib", "fastapi", "starlette", "uvicorn", "scipy.signal", "scipy.stats")
    resident = int(next(l for l in open("/proc/self/status") if l.startswith("VmRSS")).split()[1])
    good = [f.verdict for f in job.result.fit.frames]
    loaded = [m for m in heavy if m in sys.modules]
    said = json.dumps({"state": job.state, "good": good, "loaded": loaded, "kb": resident})
    (Path(folder) / "found.json").write_text(said)  # beside the log, which other threads still write
    engine.close()
"""


@pytest.mark.long
def test_a_series_with_fits_loads_neither_compiler_nor_pictures_nor_web(lab_of_its_own, tmp_path):
    lab = lab_of_its_own()
    script = tmp_path / "series.py"
    script.write_text(SERIES)
    command = [sys.executable, script, lab.endpoints, tmp_path, json.dumps(REQUEST)]
    subprocess.run(command, capture_output=True, timeout=180, check=True)
    found = json.loads((tmp_path / "found.json").read_text())
    assert (found["state"], found["good"], found["loaded"]) == ("done", ["good"] * 3, [])
    assert found["kb"] < 200_000


@pytest.mark.long
def test_a_fit_worker_that_is_killed_costs_neither_a_shot_nor_a_fit(lab_of_its_own, tmp_path):
    lab = lab_of_its_own()
    online, computing = hardware_workers(WorkerLimits())
    engine = start_engine(lab.file(), online=online, computing=computing)
    try:
        plan = plan_series(engine, AcquisitionRequest.model_validate({**REQUEST, "shots": 6}))
        job = engine.submit(series_work(engine, plan, OwnFile(None, tmp_path)))
        killed = set()
        for shots in (1, 3):
            wait_for(lambda shots=shots: (job.result.shots or 0) >= shots and online.pid is not None)
            killed.add(online.pid)
            os.kill(online.pid, signal.SIGKILL)
        assert job.ended.wait(120)
        assert (job.state, job.error) == ("done", None)
        assert [frame.verdict for frame in job.result.fit.frames] == ["good"] * 6
        assert online.pid not in killed
        # The same fits as of the recording by whoever has it.
        path = tmp_path / job.result.file
        assert len(open_recording(path).frame_info) == 6
    finally:
        engine.close()
    assert not lab.violations()
