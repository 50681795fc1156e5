"""Waiting for contacts that move."""

from __future__ import annotations

import time
from collections.abc import Callable

from drivers.errors import DeviceFault
from drivers.tx_rx_switch import SwitchPosition, SwitchTiming

ARRIVAL_S = 0.2  # beyond the switch's own times
POLL_S = 1e-3


def come_to_rest(
    position: Callable[[], SwitchPosition], target: SwitchPosition, timing: SwitchTiming, where: str, *, moved: bool
) -> None:
    """Wait until the contacts are on `target` for good; `moved`: they may just have arrived there, and still bounce.

    Raises DeviceFault if they do not come within the switch's times and ARRIVAL_S.
    """
    if moved:
        _wait_for(position, target, timing, where)
        time.sleep(timing.bounce_s)
    _wait_for(position, target, timing, where)


def _wait_for(position: Callable[[], SwitchPosition], target: SwitchPosition, timing: SwitchTiming, where: str) -> None:
    deadline = time.monotonic() + timing.total_s + ARRIVAL_S
    while (found := position()) is not target:
        if time.monotonic() > deadline:
            raise DeviceFault(
                f"the contacts are on {found.value}, not on {target.value}", where=where, remedy="check the relay"
            )
        time.sleep(POLL_S)
