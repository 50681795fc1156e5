"""Before the first shot: a line that some cards cannot drive does move the switch.  No power, no gate."""

from __future__ import annotations

import time

import structlog

from drivers.errors import DeviceFault
from drivers.platform import Platform
from drivers.timeline import DigitalLine, LineLevel, Timeline
from drivers.tx_rx_switch import SwitchPosition

log = structlog.get_logger()

MARGIN_S = 0.1  # on top of the switch's own times


def prove_lines(platform: Platform) -> None:
    """Raise the receiver's line with the gate low, and see the switch follow; nothing to do if the card vouches for it.

    A switch that does not read back proves nothing, which is logged.  Raises DeviceFault if it does not follow.
    """
    can = platform.card.capabilities()
    if DigitalLine.RX_CONNECT not in can.unproved_lines:
        return
    if not getattr(platform.switch, "reads_back", True):
        log.warning("line_not_proved", line=DigitalLine.RX_CONNECT.value, why="the switch does not read back")
        return
    length_s = platform.switch.timing().total_s + MARGIN_S
    samples = (round(length_s * can.clock.rate_hz) // can.step_samples + 1) * can.step_samples
    line = LineLevel(DigitalLine.RX_CONNECT, 0, samples)
    platform.card.program(Timeline(can.clock, 0, samples - 1, 1, (), (line,)))
    platform.card.arm()
    try:
        platform.card.trigger()
        followed = _follows(platform, length_s)
    finally:
        platform.card.stop()
        platform.switch.to_transmit()
    if not followed:
        raise DeviceFault(
            "the switch does not follow the card's line",
            where="io_card.lines.rx_connect",
            why="the line was high and the contacts stayed; images of RedPitayaDAQServer 0.11.1 drive AO0 only, "
            "whatever version they report",
            remedy="check the cable from the card to the switch, or load an image made after 0.11.1",
        )


def _follows(platform: Platform, within_s: float) -> bool:
    deadline = time.monotonic() + within_s
    while time.monotonic() < deadline:
        if platform.switch.position() is SwitchPosition.RECEIVE:
            return True
    return False
