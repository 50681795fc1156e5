"""An emulated lab with a daemon on it, as the processes that it is."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any, Literal

import httpx2

from drivers.errors import DeviceDenied
from drivers.tx_rx_switch import SwitchPosition
from platform_daemon.core.guard.fault_latch import Fault
from tests.kit.emulated_lab import Lab
from tests.kit.processes import child_of
from tests.kit.rest import client_at

Moment = Literal["tx", "rx", "between"]
SERIES = {"resonator": "jewel", "shots": 2000, "sequence": {"rx_s": 0.25, "pause_s": 0.15}}
_ASK_S = 2e-3  # the emulator runs in this process, too
_AHEAD = -10
_MOMENT_S = 30.0
_END_S = 60.0


def go_ahead() -> None:
    """From now on this process goes before the daemons that it starts, if the account may.

    Devices answer at once, however busy the computer of the daemon is, and so must those that are emulated here.
    """
    with contextlib.suppress(PermissionError):
        os.setpriority(os.PRIO_PROCESS, 0, _AHEAD)


class NotThere(AssertionError):
    """The moment to strike did not come."""


class Bench:
    """The daemon is started when it is needed, with a state folder of its own.  options: further ones of `serve`.

    starts: when shots have begun, as far as somebody looked, s; usual_s: between two of them when nothing is struck;
    halted: a process that was halted and is to go on; told: what POST /stop was answered, asks: while it was not.
    """

    def __init__(self, folder: Path, seed: int, options: tuple[str, ...] = ()) -> None:
        self.lab = Lab(folder, 'specimen="../resonators/jewel.toml"', f"world.seed={seed}", f"seed={seed}")
        self.world = self.lab.emulator.world
        self._folder, self._options = folder, options
        self._use_state()
        self.process: subprocess.Popen[str] | None = None
        self.address = self.stop_address = ""
        self._http = client_at("")
        self._job = ""
        self.starts: list[float] = []
        self.usual_s: float | None = None
        self.halted: int | None = None
        self.told: str | None = None
        self.asks: threading.Thread | None = None
        self._seen = 0

    def _use_state(self) -> None:
        """The folder of the guards, and of `reset_fault` in this process, which may have several benches."""
        os.environ["XDG_STATE_HOME"] = str(self._folder / "state")

    def end(self) -> None:
        """Daemon and lab end."""
        self.stop_daemon()
        self.lab.emulator.close()

    def stop_daemon(self) -> None:
        """Whatever is left of it and of its processes is gone."""
        process, self.process = self.process, None
        if process is None:
            return
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
        try:
            process.wait(_END_S)
        except subprocess.TimeoutExpired:
            process.kill()
        assert process.stdout is not None
        process.stdout.read()  # until the last that holds its end of the pipe is gone

    def begin(self) -> None:
        """A daemon that measures."""
        self.lab.control("repair")
        if self.process is None or self.process.poll() is not None:
            self.start_soon()
        self.wait_started()
        if self._job and self.get(self._job)["state"] in ("queued", "running"):
            return
        answer = self.post("/acquisitions", SERIES)
        if answer.status_code == 409:  # a fault stands
            self.post("/platform/fault/reset", {"by": "a campaign", "reason": "a strike on purpose"})
            answer = self.post("/acquisitions", SERIES)
        assert answer.status_code == 202, answer.text
        self._job = answer.headers["location"]
        self.usual_s = None

    def start_soon(self) -> None:
        """A daemon begins to start, unless there is one; a fault that the last one has left is reset."""
        if self.process is not None and self.process.poll() is None:
            return
        self.stop_daemon()
        self.reset_fault()
        self._spawn()

    def reset_fault(self) -> Fault | None:
        """As a person does who has looked at the platform, once the guard has let go of it; the fault that stood."""
        until = time.monotonic() + _END_S
        self._use_state()
        while True:
            try:
                return self.lab.reset_fault()
            except DeviceDenied:
                if time.monotonic() > until:
                    raise
                time.sleep(0.1)

    def start(self) -> None:
        """A daemon on the lab."""
        self._spawn()
        self.wait_started()

    def _spawn(self) -> None:
        self._use_state()
        self.address = ""
        ahead = os.getpriority(os.PRIO_PROCESS, 0)
        command = [
            *(["nice", "-n", str(-ahead)] if ahead < 0 else []),
            sys.executable,
            "-m",
            "platform_daemon",
            "serve",
            "--port",
            "0",
            "--data",
            str(self._folder / "data"),
        ]
        where = ["--platform", "emulated", "--endpoints", str(self.lab.endpoints)]
        with (self._folder / "daemon.log").open("ab") as log:
            self.process = subprocess.Popen(
                [*command, *where, *self._options], stdout=subprocess.PIPE, stderr=log, text=True
            )

    def wait_started(self) -> None:
        """Until it answers."""
        if self.address:
            return
        assert self.process is not None
        assert self.process.stdout is not None
        self.address, self.stop_address = (self.process.stdout.readline().split()[-1] for _ in "12")
        self._job = ""

    # --- what the daemon says

    def answers(self) -> bool:
        """Does the web?"""
        try:
            return self._http.get(f"{self.address}/health", timeout=10).status_code == 200
        except httpx2.HTTPError:
            return False

    def stop_port_answers(self) -> bool:
        """Does the process for stop?  Whoever connects while it is started anew waits, and is not refused."""
        try:
            url = self.stop_address.replace("/stop", "/health")
            return httpx2.get(url, timeout=20).status_code == 200
        except httpx2.HTTPError:
            return False

    def ask_to_stop(self) -> None:
        """POST /stop on its own port, in a thread: `told` has the answer once it is there."""

        def ask() -> None:
            try:
                self.told = httpx2.post(self.stop_address, timeout=60).text
            except httpx2.HTTPError as error:
                self.told = repr(error)

        self.told = None
        self.asks = threading.Thread(target=ask, name="stop", daemon=True)
        self.asks.start()

    def wait_for_hardware(self) -> None:
        """Until the hardware process has been started anew."""
        until = time.monotonic() + _END_S
        while httpx2.get(f"{self.address}/platform", timeout=30).status_code != 200:
            assert time.monotonic() < until, "the hardware process does not come back"
            time.sleep(0.05)

    def series_ended(self) -> bool:
        """Has the series ended?"""
        return self.get(self._job)["state"] not in ("queued", "running")

    def end_series(self) -> None:
        """It is cancelled, or has ended before."""
        self._http.delete(f"{self.address}{self._job}")
        until = time.monotonic() + _END_S
        while not self.series_ended():
            assert time.monotonic() < until, "the series does not end"
            time.sleep(0.05)

    def get(self, path: str) -> Any:
        """What it answers."""
        answer = self._http.get(f"{self.address}{path}")
        assert answer.status_code == 200, answer.text
        return answer.json()

    def post(self, path: str, body: Any) -> Any:
        """The answer."""
        return self._http.post(f"{self.address}{path}", json=body)

    # --- processes

    def parent(self) -> int:
        """Its id."""
        assert self.process is not None
        return self.process.pid

    def hardware(self) -> int:
        """Its id."""
        return child_of(self.parent(), "platform_daemon.processes", "hardware")

    def web(self) -> int:
        """Its id."""
        return child_of(self.parent(), "platform_daemon.processes", "web")

    def stop(self) -> int:
        """Its id."""
        return child_of(self.parent(), "platform_daemon.processes", "stop")

    def go_on(self) -> None:
        """What was halted goes on, if it is still there."""
        pid, self.halted = self.halted, None
        if pid is not None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGCONT)

    def guard(self) -> int:
        """Its id."""
        return child_of(self.hardware(), "platform_daemon.core.guard")

    def worker(self) -> int:
        """Id of the one that makes the on-line fits."""
        return child_of(self.hardware(), "spawn_main")

    # --- what the world says

    def look_anew(self) -> None:
        """What has begun while nobody looked is not noted."""
        self._seen = self.world.shots

    def look(self) -> None:
        """Note that a shot has begun."""
        if self.world.shots > self._seen:
            self._seen = self.world.shots
            self.starts.append(time.monotonic())

    def power_until_s(self, since_s: float) -> float:
        """How long after that world time power could reach the coils, s."""
        return max([0.0, *(span.stop_s - since_s for span in self.world.power_log())])

    @property
    def outputs_on(self) -> bool:
        """The amplifier is enabled, a DAC plays, the gate is high, or the receiver is not disconnected."""
        return self.world.power.enabled or self.card_on

    @property
    def card_on(self) -> bool:
        """A DAC plays, the gate is high, or the receiver is not disconnected: what the card's lines do."""
        if self._position() is not SwitchPosition.TRANSMIT:
            return True
        found = self.lab.control("outputs")
        return bool(found["playing"] or found["pa_gate"])

    def _position(self) -> SwitchPosition:
        return self.world.contacts().position(self.world.clock.monotonic_s())

    def wait_for(self, moment: Moment) -> None:
        """Until power is on, the receiver is connected, or a shot has ended and none has begun.  Raises NotThere."""
        until, first = time.monotonic() + _MOMENT_S, self.world.shots
        self.look_anew()
        while time.monotonic() < until:
            self.look()
            receives = self._position() is SwitchPosition.RECEIVE
            here = {"tx": self.world.power.enabled and self.world.is_running() and not receives, "rx": receives,
                    "between": self.world.shots > first and not self.world.is_running() and not receives}  # fmt: skip
            if self.world.shots > first and here[moment]:  # not before one shot was whole
                self.look()
                return
            time.sleep(_ASK_S)
        raise NotThere(f"no {moment} within {_MOMENT_S:g} s")
