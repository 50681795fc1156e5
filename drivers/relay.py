"""Waits until the contacts of a relay have settled."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable

from drivers.errors import DeviceFault
from drivers.tx_rx_switch import SwitchPosition, SwitchTiming

ARRIVAL_S = 0.2  # beyond the switch's own times
POLL_S = 1e-3
LOOKS = 3  # at least: on a busy host a single read-back may take longer than the deadline


def wait_until_settled(
    position: Callable[[], SwitchPosition], target: SwitchPosition, timing: SwitchTiming, where: str
) -> None:
    """Wait until the contacts are on `target`, then for their bounces, then until they are on `target` again.

    Raises DeviceFault if they are not there within the switch's times and ARRIVAL_S, or leave again for as long.
    """
    _wait_for(position, target, timing, where)
    time.sleep(timing.bounce_s)
    _wait_for(position, target, timing, where)


def _wait_for(position: Callable[[], SwitchPosition], target: SwitchPosition, timing: SwitchTiming, where: str) -> None:
    deadline = time.monotonic() + timing.total_s + ARRIVAL_S
    for look in itertools.count(1):
        if (found := position()) is target:
            return
        if time.monotonic() > deadline and look >= LOOKS:
            raise DeviceFault(
                f"the contacts are on {found.value}, not on {target.value}", where=where, remedy="check the relay"
            )
        time.sleep(POLL_S)
