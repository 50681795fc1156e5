"""Reads back every device into one plain dictionary."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from drivers.platform import Platform


def platform_status(platform: Platform) -> dict[str, Any]:
    """Identity and state of each device, units in the names.  Raises DeviceError if one does not answer."""
    card = platform.card.capabilities()
    return {
        "platform": platform.name,
        "io_card": {
            "identity": asdict(platform.card.identity()),
            "state": str(platform.card.state()),
            "inputs": card.inputs,
            "outputs": card.outputs,
            "sampling_rate_hz": card.clock.rate_hz,
        },
        "tx_rx_switch": {
            "identity": asdict(platform.switch.identity()),
            "position": str(platform.switch.position()),
            "total_time_s": platform.switch.timing().total_s,
        },
        "power_amplifier": {
            "identity": asdict(platform.amplifier.identity()),
            **asdict(platform.amplifier.status()),
        },
        "lna": {
            "identity": asdict(platform.lna.identity()),
            "gain": platform.lna.gain(),
            "overloaded": platform.lna.overloaded(),
        },
        "temperature_c": platform.thermometer.temperature_c() if platform.thermometer else None,
        "calibration": {"identifier": platform.calibration.identifier, "date": platform.calibration.date},
        "error": None,
    }
