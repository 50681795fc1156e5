"""A daemon as the processes that it is."""

from __future__ import annotations

import os
import signal
import subprocess
from contextlib import contextmanager
from pathlib import Path

import httpx2

from tests.kit.command_line import COMMAND


class Served:
    """A daemon and its processes."""

    def __init__(self, process, address, stop):
        self.process, self.address, self.stop = process, address, stop

    def pid(self, name):
        children = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text().split()
        for pid in children:
            words = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
            if words[2:4] == [b"platform_daemon.serving", name.encode()]:
                return int(pid)
        return None

    def kill(self, name, number=signal.SIGKILL):
        pid = self.pid(name)
        os.kill(pid, number)
        return pid

    def get(self, path):
        return httpx2.get(f"{self.address}{path}", timeout=30)

    def post(self, path, body):
        return httpx2.post(f"{self.address}{path}", json=body, timeout=30)


@contextmanager
def served(data, *options):
    command = [COMMAND, "serve", "--port", "0", "--data", data, *options]
    with data.with_suffix(".log").open("w") as log:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=log, text=True)
        try:
            address, stop = (process.stdout.readline().split()[-1] for _ in range(2))
            yield Served(process, address, stop)
        finally:
            process.send_signal(signal.SIGTERM)
            process.stdout.read()
            process.wait(60)
