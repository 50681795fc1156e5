"""A daemon as the processes that it is."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
from contextlib import contextmanager
from pathlib import Path

from tests.kit.command_line import COMMAND, wait_for
from tests.kit.rest import client_at


class Served:
    """A daemon and its processes."""

    def __init__(self, process, address, stop, folder):
        self.process, self.address, self.stop, self.folder = process, address, stop, folder
        self._http = client_at(address)

    def pid(self, name):
        children = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text().split()
        for pid in children:
            words = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
            if words[3:5] == [b"platform_daemon.processes", name.encode()]:
                return int(pid)
        return None

    def kill(self, name, number=signal.SIGKILL):
        pid = self.pid(name)
        os.kill(pid, number)
        return pid

    def get(self, path, **keys):
        return self._http.get(path, **keys)

    def post(self, path, body):
        return self._http.post(path, json=body)

    def put(self, path, body):
        return self._http.put(path, json=body)

    def delete(self, path):
        return self._http.delete(path)

    def stop_all(self):
        return self._http.post(self.stop)

    def close(self):
        self._http.close()


@contextmanager
def served(data, *options, checkout=None):
    """checkout: folder of another one, with its .venv, whose program is served; None: this one."""
    program = COMMAND if checkout is None else checkout / ".venv/bin" / COMMAND.name
    port = () if "--port" in options else ("--port", "0")
    command = [program, "serve", *port, "--data", data, *options]
    with data.with_suffix(".log").open("w") as log:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=log, text=True, cwd=checkout)
        try:
            address, stop = (process.stdout.readline().split()[-1] for _ in range(2))
            running = Served(process, address, stop, data)
            with contextlib.closing(running):
                yield running
        finally:
            process.send_signal(signal.SIGTERM)
            process.stdout.read()
            process.wait(60)


@contextmanager
def ready(data, *options, checkout=None):
    """As `served`, once everything is warmed up."""
    with served(data, *options, checkout=checkout) as running:
        wait_for(lambda: running.get("/ready").status_code == 200, timeout=300)
        yield running
