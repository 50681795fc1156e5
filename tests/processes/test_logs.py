"""The log in files: lines of JSON, of bounded size, and no matter what the disk does."""

import json
import subprocess
import sys

import pytest

PROGRAM = """
import logging, pathlib, sys, structlog
from platform_daemon.core.state import logs
logs._BYTES = 2000
logs.log_from(logging.INFO)
logs.keep_log(pathlib.Path(sys.argv[1]), "hardware")
for k in range(int(sys.argv[2])):
    structlog.get_logger().info("job_started", job=f"acquisition-{k}", path=pathlib.Path("a"))
"""


def logged(folder, lines):
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, folder, str(lines)], capture_output=True, text=True, timeout=60, check=True
    )
    return done.stderr


def test_every_event_is_a_line_of_json_and_the_oldest_files_go(tmp_path):
    logged(tmp_path / "logs", 3)
    lines = [json.loads(line) for line in (tmp_path / "logs/hardware.jsonl").read_text().splitlines()]
    assert [(each["event"], each["job"]) for each in lines] == [("job_started", f"acquisition-{k}") for k in range(3)]
    assert list(lines[0])[:3] == ["timestamp", "level", "event"]
    logged(tmp_path / "logs", 400)
    files = list((tmp_path / "logs").iterdir())
    assert len(files) == 6
    assert all(file.stat().st_size <= 2000 for file in files)
    assert "acquisition-399" in (tmp_path / "logs/hardware.jsonl").read_text()


@pytest.mark.parametrize("blocked", ["folder", "file"])
def test_a_log_that_cannot_be_kept_costs_nothing_else(tmp_path, blocked):
    if blocked == "folder":
        (tmp_path / "logs").write_text("")
    else:
        (tmp_path / "logs/hardware.jsonl").mkdir(parents=True)
    said = logged(tmp_path / "logs", 3)
    assert said.count("job_started") == 3
    assert "Traceback" not in said
