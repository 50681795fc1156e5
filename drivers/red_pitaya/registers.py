"""The registers that survive a reconnect, whoever set them, as commands."""

from __future__ import annotations

from collections.abc import Sequence

from drivers.red_pitaya.layout import pin_header
from drivers.red_pitaya.options import CardTable
from drivers.red_pitaya.silence import SINES

TO_CONFIGURE = ("RP:MODE ACQUISITION", "RP:TRIGGER OFF", "RP:TRIGGER:ALIVE OFF", "RP:MODE CONFIGURATION")
"""The trigger must be off to leave ACQUISITION."""


def registers(table: CardTable, outputs: Sequence[str], inputs: Sequence[str], *, is_last: bool) -> list[str]:
    """For a board with these DIO pins; the last one passes no trigger on."""
    return [
        "RP:ADC:FIRENABLED ON",
        f"RP:ADC:DECIMATION {table.decimation}",
        f"RP:TRIGGER:MODE {table.trigger.upper()}",
        f"RP:TRIGGER:PROP {'OFF' if is_last else 'ON'}",
        "RP:COUNTERTRIGGER:ENABLE OFF",
        "RP:COUNTER:SAMPLESPERSTEP 0",
        f"RP:INSTANTRESET:MODE {'ON' if table.instant_reset else 'OFF'}",
        *(f"RP:DAC:CHANNEL{o}:RAMPING:ENABLE OFF" for o in (0, 1)),
        *(f"RP:DAC:CHANNEL{o}:COMPONENT{c}:SIGNALTYPE SINE" for o, c in SINES),
        *(f"{pin_header(pin)}:HBRIDGE OFF" for pin in outputs),  # or it carries pulses, not a level
        *(f"{pin_header(pin)}:DIR OUT" for pin in outputs),
        *(f"{pin_header(pin)}:DIR IN" for pin in inputs),
    ]
