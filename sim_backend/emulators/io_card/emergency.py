"""A card's emergency input DIO3_P, the counter on three of its pins, and a wire that may join them.

From the Verilog of server 0.11.1: the counter (sequence_stepper.v, joined in bd.tcl) begins with the trigger, takes its
step while it is held in reset, and its three bits are ORed onto DIO2_N, DIO3_N and DIO4_N.  The input (reset_manager.v)
holds all outputs, the step counter and this counter in reset from the moment on at which it is high with the trigger
on, until the trigger falls.  On the compiled server with a stand-in for the FPGA the wire was seen to act so.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

BITS = {"2N": 0, "3N": 1, "4N": 2}
INPUT = "3P"
COUNTS = 8


@dataclass
class Emergency:
    """Of one card.

    pressed: from outside; latched: since it was high with the trigger on; wire: from one pin to another (names as in
    `registers.PINS`, or INPUT), None: there is none; step: samples per count, 0: the counter stands still; since:
    sample after the trigger from which on all this is so.
    """

    wire: tuple[str, str] | None
    pressed: bool = False
    latched: bool = False
    step: float = 0.0
    since: float = 0.0

    def begun(self, step: float) -> None:
        """The trigger has come."""
        self.step, self.since = step, 0.0

    def source(self, pin: str) -> str | None:
        """The pin whose level this one gets by the wire."""
        return self.wire[0] if self.wire is not None and self.wire[1] == pin else None

    def counts(self, pin: str, elapsed: float) -> bool:
        """Whether the counter drives this pin high, so many samples after the trigger."""
        bit = BITS.get(pin)
        if bit is None or not self.step or self.latched:
            return False
        return bool(int(elapsed / self.step) >> bit & 1)

    def due(self) -> float:
        """The sample after the trigger at which the counter presses the input by the wire; inf: never."""
        source = self.source(INPUT)
        if source not in BITS or not self.step or self.latched:
            return math.inf
        high = self.step * 2 ** BITS[source]
        if self.counts(source, self.since):
            return self.since
        return high * (2 * math.floor(self.since / (2 * high)) + 1)
