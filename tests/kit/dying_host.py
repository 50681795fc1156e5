"""A program on the emulated wires that is killed, stopped or told to end, and how long its outputs stay on then."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Literal

from drivers.tx_rx_switch import SwitchPosition
from tests.kit.emulated_lab import Lab

Moment = Literal["tx", "rx", "between"]
_ASK_S = 2e-3  # the emulator runs in this process, too


class DyingHost:
    """`platform-daemon measure` over many shots."""

    def __init__(self, lab: Lab, folder: Path) -> None:
        self._world = lab.emulator.world
        shots = ["--resonator", "jewel", "--rx-s", "0.4", "--pause-s", "0.3", "--shots", "200", "--out", "dying.h5"]
        where = ["--platform", "emulated", "--endpoints", str(lab.endpoints)]
        self.log = folder / "host.log"
        with self.log.open("wb") as log:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "platform_daemon", "measure", *where, *shots, "--force"],
                cwd=folder, stdout=log, stderr=log, start_new_session=True,
            )  # fmt: skip

    @property
    def outputs_on(self) -> bool:
        """The amplifier is enabled, the card plays, or the receiver is not disconnected."""
        return self._world.power.enabled or self._world.is_running() or self._contacts() is not SwitchPosition.TRANSMIT

    def _contacts(self) -> SwitchPosition:
        return self._world.contacts().position(self._world.clock.monotonic_s())

    def wait_for(self, moment: Moment, within_s: float = 60.0) -> None:
        """Until power is on, the receiver is connected, or a shot has ended and none has begun."""
        until = time.monotonic() + within_s
        seen = False
        while time.monotonic() < until:
            assert self.process.poll() is None, self.log.read_text()
            powered = self._world.power.enabled
            receives = self._contacts() is SwitchPosition.RECEIVE
            seen = seen or receives
            if {"tx": powered, "rx": receives, "between": seen and not self.outputs_on}[moment]:
                return
            time.sleep(_ASK_S)
        raise AssertionError(f"no {moment} within {within_s:g} s: {self.log.read_text()}")

    def send(self, number: signal.Signals) -> None:
        """A signal to the program alone, not to what it has started."""
        os.kill(self.process.pid, number)

    def off_after(self, within_s: float) -> tuple[float, float]:
        """Seconds until the amplifier is disabled, and until all outputs are off.

        Raises AssertionError if they are not by then.
        """
        began, disabled_s = time.monotonic(), None
        while self.outputs_on:
            passed_s = time.monotonic() - began
            assert passed_s < within_s, f"outputs still on: {self.log.read_text()}"
            disabled_s = passed_s if disabled_s is None and not self._world.power.enabled else disabled_s
            time.sleep(_ASK_S)
        all_s = time.monotonic() - began
        return all_s if disabled_s is None else disabled_s, all_s

    def end(self) -> None:
        """Whatever is left of it."""
        self.process.kill()
        self.process.wait()
