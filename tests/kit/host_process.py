"""The host of a lab as a process of its own, so that it can be made to stand still while the lab goes on."""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
import threading
import time
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import structlog

from drivers.errors import DeviceError, PlatformError
from drivers.platform import Platform
from drivers.registry import build_platform
from drivers.timeline import DigitalLine
from platform_daemon.core.hardware.shot import run_shot
from platform_daemon.core.settings import load_platform, load_sequence
from sequences.compiler import ShotPlan, TransmitSide, compile_shot
from tests.kit.watch import Watch

TX_PERIODS, RX_S = 20, 0.12
ANSWER_S = 90.0  # the longest that giving up on all devices may take
GOOD, REFUSED, ENDED, OFF, NOT_OFF = "good", "refused", "ended", "off", "not off"


class Host:
    """Asked for one thing at a time: `ask` what, then `answer` tells how it ended."""

    def __init__(self, endpoints: Path, overrides: tuple[str, ...]) -> None:
        """Raises EOFError if the platform cannot be built."""
        context = multiprocessing.get_context("spawn")
        self._link, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, endpoints, overrides))
        self._process.start()
        theirs.close()
        self.gate_s, self.connect_s = self._link.recv()

    def ask(self, what: str) -> None:
        """`shot`, or `off`: prove that all outputs are off."""
        self._link.send(what)

    def answer(self) -> tuple[str, str, float]:
        """How it ended, why, and how long the process stood still meanwhile, s.

        Raises AssertionError if nothing comes: the host hangs.
        """
        assert self._link.poll(ANSWER_S), "the host hangs"
        ended, why, still_s = self._link.recv()
        return str(ended), str(why), float(still_s)

    def stand_still(self, seconds: float) -> None:
        """The process does nothing for so long, whatever it was at."""
        assert self._process.pid is not None
        os.kill(self._process.pid, signal.SIGSTOP)
        try:
            time.sleep(seconds)
        finally:
            os.kill(self._process.pid, signal.SIGCONT)

    def kill(self) -> None:
        """It is gone at once, whatever it was at."""
        self._process.kill()
        self._process.join()

    def end(self) -> None:
        """It is killed if it does not end by itself."""
        self._link.close()
        self._process.join(20)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


def _serve(link: Connection, endpoints: Path, overrides: tuple[str, ...]) -> None:
    structlog.configure(wrapper_class=structlog.make_filtering_bound_logger(logging.CRITICAL))
    threading.excepthook = lambda _: None  # of devices whose wire was cut
    file = load_platform("emulated", overrides, endpoints)
    platform = build_platform(file.section)
    plan = _plan(platform, file.limits)
    gate, receiver = (
        next(e for e in plan.timeline.lines if e.line is line) for line in (DigitalLine.PA_GATE, DigitalLine.RX_CONNECT)
    )
    rate_hz = plan.timeline.clock.rate_hz
    link.send(((gate.stop_sample - gate.start_sample) / rate_hz, receiver.start_sample / rate_hz))
    try:
        while True:
            what = link.recv()
            with Watch() as watch:
                came = _shot(platform, plan) if what == "shot" else _off(platform)
            link.send((*came, watch.total_s))
    except EOFError:
        platform.close()


def _plan(platform: Platform, limits: Any) -> ShotPlan:
    can = platform.card.capabilities()
    jewel, late_s = load_sequence("jewel"), can.line_delay_s
    keys = {
        "tx_periods": TX_PERIODS,
        "rx_s": RX_S,
        "switch_s": jewel.switch_s + 2 * late_s,
        "guard_samples": jewel.guard_samples + round(late_s * can.clock.rate_hz),
    }
    return compile_shot(
        jewel.model_copy(update=keys), TransmitSide(platform.transmit, can, platform.switch.timing(), limits)
    )


def _shot(platform: Platform, plan: ShotPlan) -> tuple[str, str]:
    try:
        reason = run_shot(platform, plan).reason
    except PlatformError as error:
        return ENDED, f"{type(error).__name__}: {error}"
    return (GOOD, "") if reason is None else (REFUSED, reason)


def _off(platform: Platform) -> tuple[str, str]:
    try:
        platform.outputs_off()
    except DeviceError as error:
        return NOT_OFF, str(error)
    return OFF, ""
