"""What is done to the daemon or its lab, and what must come of it."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from platform_daemon.core.guard.watch import LEASE_S
from platform_daemon.core.service.stopping import SILENT_S
from tests.campaigns.crash.bench import Bench, Moment

KILL_S = 0.1
"""The amplifier is disabled within this time of a kill, in the median."""
STOP_HANG_S = SILENT_S + 0.3
"""... and of a hang, where a stop is requested."""
HANG_S = LEASE_S + 0.2
"""... and of a hang or a dead link."""
LATE_S = 0.5
"""A shot that begins so much after its time is late."""
ALL: tuple[Moment, ...] = ("tx", "rx", "between")
POWERED: tuple[Moment, ...] = ("tx", "rx")


@dataclass(frozen=True)
class Strike:
    """`must`: the outputs go off, with the amplifier disabled within `median_s` in the median; off or on: the same, or
    the next shot is made as if nothing had been; the series goes on, no shot late; or power ends by the wiring alone,
    and the amplifier stays enabled.

    `ends`: the daemon is gone then; its hardware process is, and is started anew; or nothing of it.  Where it lives the
    next strike meets the same one, and the same series where that goes on.

    `among`: so many strikes are of one kind, on several wires or of several processes, and share its number."""

    name: str
    moments: tuple[Moment, ...]
    do: Callable[[Bench], None]
    must: Literal["off", "off or on", "go on", "wiring"] = "off"
    median_s: float = KILL_S
    ends: Literal["daemon", "hardware", "nothing"] = "daemon"
    among: int = 1


def _send(number: signal.Signals, *to: Callable[[Bench], int]) -> Callable[[Bench], None]:
    def do(bench: Bench) -> None:
        for pid in [each(bench) for each in to]:  # all are known before the first is gone
            os.kill(pid, number)

    return do


def _halt(which: Callable[[Bench], int]) -> Callable[[Bench], None]:
    """Until the series was seen to go on."""

    def do(bench: Bench) -> None:
        bench.halted = which(bench)
        os.kill(bench.halted, signal.SIGSTOP)

    return do


def _halt_and_stop(bench: Bench) -> None:
    os.kill(bench.hardware(), signal.SIGSTOP)
    bench.ask_to_stop()


def _twice(bench: Bench) -> None:
    for pause_s in (0.05, 0.0):
        os.kill(bench.parent(), signal.SIGINT)
        time.sleep(pause_s)


def _wire(device: str, kind: str, count: int = 1) -> Callable[[Bench], None]:
    def do(bench: Bench) -> None:
        bench.lab.control(
            "wire_fault", device=device, kind=kind, count=count, **({"delay_s": 0.3} if count > 1 else {})
        )

    return do


def _power_cut(bench: Bench) -> None:
    """Its server is gone and its outputs are as at power-up; later it has power again."""
    bench.lab.kill_server(0)
    board = bench.lab.emulator.cards.boards[0]
    board.power_up(board.options)
    time.sleep(0.2)
    bench.lab.start_server(0)


_parent, _hardware, _web, _worker, _guard = Bench.parent, Bench.hardware, Bench.web, Bench.worker, Bench.guard
STRIKES = (
    Strike("hardware process, SIGKILL", ALL, _send(signal.SIGKILL, _hardware), ends="hardware"),
    Strike("hardware process, SIGSEGV", ALL, _send(signal.SIGSEGV, _hardware), ends="hardware"),
    Strike("hardware process, SIGSTOP", POWERED, _send(signal.SIGSTOP, _hardware), median_s=HANG_S, ends="hardware"),
    Strike("hardware process, SIGSTOP, and POST /stop", POWERED, _halt_and_stop, median_s=STOP_HANG_S,
           ends="hardware", among=4),
    Strike("web process, SIGKILL", ALL, _send(signal.SIGKILL, _web), must="go on", ends="nothing"),
    Strike("web process, SIGSTOP", ALL, _halt(_web), must="go on", ends="nothing", among=4),
    Strike("worker, SIGKILL", ALL, _send(signal.SIGKILL, _worker), must="go on", ends="nothing"),
    Strike("worker, SIGSTOP", ALL, _halt(_worker), must="go on", ends="nothing", among=4),
    Strike("stop process, SIGKILL", ALL, _send(signal.SIGKILL, Bench.stop), must="go on", ends="nothing", among=4),
    Strike("parent, SIGKILL", ALL, _send(signal.SIGKILL, _parent)),
    Strike("parent and hardware process, SIGKILL", ALL, _send(signal.SIGKILL, _parent, _hardware), among=2),
    Strike("parent, hardware process and guard, SIGKILL", ALL, _send(signal.SIGKILL, _parent, _guard, _hardware),
           must="wiring", among=2),
    *(Strike(f"parent, {number.name}", ALL, _send(number, _parent))
      for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGQUIT)),
    Strike("parent, SIGINT twice", ALL, _twice),
    Strike("card, link cut", ALL, _wire("io_card_0", "disconnect"), must="off or on",
           median_s=HANG_S, ends="nothing", among=3),
    Strike("card, says nothing", ALL, _wire("io_card_0", "one_way_link"), median_s=HANG_S, ends="nothing", among=4),
    Strike("card, hears nothing", ALL, _wire("io_card_0", "deaf_link"), median_s=HANG_S, ends="nothing", among=4),
    Strike("card, answers 0.3 s late, 40 times", ALL, _wire("io_card_0", "slow_link", 40), must="off or on",
           median_s=HANG_S, ends="nothing", among=3),
    Strike("switch, link cut", ALL, _wire("switch", "disconnect"), must="off or on",
           median_s=HANG_S, ends="nothing", among=3),
    Strike("switch, answers 0.3 s late, 40 times", ALL, _wire("switch", "slow_link", 40), must="off or on",
           median_s=HANG_S, ends="nothing", among=3),
    Strike("switch, says nothing", ALL, _wire("switch", "one_way_link"), median_s=HANG_S, ends="nothing", among=4),
    Strike("amplifier, link cut", ALL, _wire("amplifier", "disconnect"), must="off or on", median_s=HANG_S,
           ends="nothing", among=3),
    Strike("amplifier, answers 0.3 s late, 40 times", ALL, _wire("amplifier", "slow_link", 40), must="off or on",
           median_s=HANG_S, ends="nothing", among=3),
    Strike("amplifier, says nothing", ALL, _wire("amplifier", "one_way_link"),
           median_s=HANG_S, ends="nothing", among=4),
    Strike("card, power cut", ALL, _power_cut, median_s=HANG_S, ends="nothing"),
)  # fmt: skip
