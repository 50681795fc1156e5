"""The command line, as a process of its own or in this one."""

import contextlib
import io
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from platform_daemon.cli.main import main

COMMAND = Path(sys.executable).with_name("platform-daemon")
QUICK = ("--resonator", "jewel", "--rx-s", "0.6")
"""What `measure` is asked for: long enough for a fit, quick to simulate."""


def run(*arguments, cwd=None, timeout=120):
    command = [COMMAND, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd, timeout=timeout, check=False)


def here(*arguments):
    """Like `run`, in this process: a new one would cost seconds."""
    out, errors, before = io.StringIO(), io.StringIO(), sys.argv
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    sys.argv = ["platform-daemon", *map(str, arguments)]
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors), pytest.raises(SystemExit) as end:
            main()
    finally:
        sys.argv = before
        for number, handler in handlers.items():
            signal.signal(number, handler)
    return subprocess.CompletedProcess(sys.argv, end.value.code or 0, out.getvalue(), errors.getvalue())


def assert_one_line_error(done, code, *words):
    assert done.returncode == code, done
    lines = [line for line in done.stderr.splitlines() if line.strip()]
    assert lines[-1].startswith("error: "), done.stderr
    assert "Traceback" not in done.stderr
    for word in words:
        assert word in lines[-1]


def wait_for(condition, timeout=240):
    """The longer it takes, the less often it is asked: whoever asks all the time takes the processor from the other."""
    begun = time.monotonic()
    while not condition():
        waited = time.monotonic() - begun
        assert waited < timeout
        time.sleep(min(0.2, max(0.02, 0.05 * waited)))
