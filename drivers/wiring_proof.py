"""Before the first shot it is proved that the receiver's line moves the switch, with no power and the gate low.

Some images of the card cannot drive that line (`CardCapabilities.unproved_lines`).
"""

from __future__ import annotations

import time

import structlog

from drivers.errors import DeviceFault, DeviceTimeout
from drivers.platform import Platform
from drivers.timeline import DigitalLine, LineLevel, Timeline
from drivers.tx_rx_switch import SwitchPosition

log = structlog.get_logger()

MARGIN_S = 0.1  # on top of the switch's own times
TRIES = 3  # a busy computer may be late by more than that


def prove_lines(platform: Platform) -> None:
    """Raise the receiver's line with the gate low, and see the switch follow; nothing if the card surely drives it.

    A switch that does not read back proves nothing, which is logged.  Raises DeviceFault if it does not follow,
    DeviceTimeout if this computer was too late to see that.
    """
    can = platform.card.capabilities()
    if DigitalLine.RX_CONNECT not in can.unproved_lines:
        return
    if not platform.switch.reads_back:
        log.warning("line_not_proved", line=DigitalLine.RX_CONNECT.value, why="the switch does not read back")
        return
    length_s = platform.switch.timing().total_s + MARGIN_S
    samples = (round(length_s * can.clock.rate_hz) // can.step_samples + 1) * can.step_samples
    line = LineLevel(DigitalLine.RX_CONNECT, 0, samples)
    timeline = Timeline(can.clock, 0, samples - 1, 1, (), (line,))
    for _ in range(TRIES):
        followed = _raised(platform, timeline, length_s)
        if followed:
            return
        if followed is False:
            raise DeviceFault(
                "the switch does not follow the card's line",
                where="io_card.lines.rx_connect",
                why="the line was high and the contacts stayed; images of RedPitayaDAQServer 0.11.1 drive AO0 only, "
                "whatever version they report",
                remedy="check the cable from the card to the switch, or load an image made after 0.11.1",
            )
    raise DeviceTimeout(
        "this computer was too late to see the switch follow the card's line",
        where="io_card.lines.rx_connect",
        why=f"{TRIES} times the line was low again, after {length_s:.3f} s, before the switch had said where it is",
        remedy="start again when the computer is less busy; if it stays so, find out why card or switch answer slowly",
    )


def _raised(platform: Platform, timeline: Timeline, length_s: float) -> bool | None:
    """Play the line, high for `length_s`, s, and stop the card; returns the result of `_follows`."""
    platform.card.program(timeline)
    platform.card.arm()
    begun_s = time.monotonic()
    try:
        platform.card.trigger()
        return _follows(platform, begun_s, length_s)
    finally:
        platform.card.stop()
        platform.switch.to_transmit()


def _follows(platform: Platform, begun_s: float, length_s: float) -> bool | None:
    """Whether the switch was read back on RECEIVE; None: it was not read while the line was certainly high and the
    contacts were settled, so that the result is inconclusive.  The line rose between `begun_s` and now."""
    looked = False
    now_s = time.monotonic()
    settled_s = now_s + platform.switch.timing().total_s
    deadline_s = now_s + length_s
    while now_s < deadline_s:
        read_s = now_s
        if platform.switch.position() is SwitchPosition.RECEIVE:
            return True
        now_s = time.monotonic()
        looked |= read_s >= settled_s and now_s < begun_s + length_s
    return False if looked else None
