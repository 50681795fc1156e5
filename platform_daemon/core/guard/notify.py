"""Messages to systemd: ready, alive, ending.  See sd_notify(3), sd_watchdog_enabled(3)."""

from __future__ import annotations

import os
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from .stderr_log import log_event


class Heartbeat:
    """Called while all is well; it `lives` until it has not been called for longer than `within_s`, s."""

    def __init__(self, within_s: float) -> None:
        self._within_s = within_s
        self._last_s = time.monotonic()

    def __call__(self) -> None:
        """All is well now."""
        self._last_s = time.monotonic()

    def lives(self) -> bool:
        """See the class."""
        return time.monotonic() - self._last_s <= self._within_s


@contextmanager
def service_manager(lives: Callable[[], bool] = lambda: True) -> Iterator[None]:
    """Tell systemd READY on entry, STOPPING on exit, and in between WATCHDOG twice in each WatchdogSec while `lives()`.

    To be entered once everything serves.  lives: is called in a thread of its own; if it raises or hangs, systemd gets
    no message and ends the service, whose ExecStopPost switches the outputs off.  Without systemd nothing is done.
    """
    if not notify("READY=1"):
        yield
        return
    ended = threading.Event()
    every_s = watchdog_s()
    if every_s is not None:
        threading.Thread(target=_watch, args=(lives, every_s / 2, ended), name="watchdog", daemon=True).start()
    try:
        yield
    finally:
        ended.set()
        notify("STOPPING=1")


def notify(state: str) -> bool:
    """One datagram; False: there is no service manager, or it does not listen."""
    address = os.environ.get("NOTIFY_SOCKET", "")
    if not address:
        return False
    try:
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as to:
            to.sendto(state.encode(), "\0" + address[1:] if address.startswith("@") else address)
    except OSError as error:
        log_event("service_manager_not_told", state=state, error=str(error))
        return False
    return True


def watchdog_s() -> float | None:
    """WatchdogSec of the unit, s; None: systemd does not watch this process."""
    period_us = os.environ.get("WATCHDOG_USEC", "")
    own_pid = str(os.getpid())
    if os.environ.get("WATCHDOG_PID", own_pid) != own_pid or not period_us.isdigit() or int(period_us) == 0:
        return None
    return int(period_us) / 1e6


def _watch(lives: Callable[[], bool], every_s: float, ended: threading.Event) -> None:
    while True:
        try:
            alive = lives()
        except Exception as error:  # whatever it is, it is no sign of life
            log_event("no_sign_of_life", error=str(error))
            alive = False
        if alive and not ended.is_set():
            notify("WATCHDOG=1")
        if ended.wait(every_s):
            return
