"""After a trip: the amplifier's latched fault is cleared by a command of its own, never by the way."""

from __future__ import annotations

from dataclasses import asdict

import structlog

from drivers.platform import Platform
from platform_daemon.core.schemas.platform import AmplifierState, FaultReset

log = structlog.get_logger()


def reset_amplifier(platform: Platform) -> FaultReset:
    """Clear the amplifier's latched fault; what it was (None: there was none), and the amplifier now: disabled, muted.

    No power goes out; that the chain still is as it was, the self-test before the next series shows.  Raises
    DeviceFault if the fault stays, DeviceError if the amplifier does not answer.
    """
    fault = platform.amplifier.status().fault
    platform.amplifier.reset_fault()
    log.info("amplifier_fault_reset", fault=fault)
    return FaultReset(fault=fault, power_amplifier=AmplifierState(**asdict(platform.amplifier.status())))
