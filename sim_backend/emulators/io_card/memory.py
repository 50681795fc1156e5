"""How often the server touches its sequence memory, which on a board is what a shot waits for.

Counted in the source of the server; on the real one, at 250 ns per access, SEQ:SET took 17.8, 35.4, 44.2 and 55.0 ms
with 1 to 4 channels, and clearing 44 ms.  Neither depends on the length of the sequence: always the whole ring.
"""

from __future__ import annotations

from .registers import OUTPUTS, SEQUENCE_CHANNELS

RING = 8192
LOOKAHEAD = 7372  # steps that are filled ahead
ENABLE = 2  # a bit is read, cleared and set
# value, enable bit, and for OUT1 and OUT2 resync and ramp bits
OUTPUT_STEP = 7
SLOW_STEP = 3
TABLE_WORDS = 8192  # of an output's waveform table
CLEARED_CHANNELS = 5  # the server forgets the sixth


def enable_accesses(channels: int) -> int:
    """The enable bits of the whole ring."""
    return ENABLE * RING * min(max(channels, 0), SEQUENCE_CHANNELS)


def set_accesses(channels: int) -> int:
    """Of SEQ:SET: the enable bits of the whole ring, then all steps that are filled ahead."""
    used = min(max(channels, 0), SEQUENCE_CHANNELS)
    outputs = min(used, OUTPUTS)
    return enable_accesses(used) + LOOKAHEAD * (OUTPUT_STEP * outputs + SLOW_STEP * (used - outputs))


CLEAR_ACCESSES = OUTPUTS * TABLE_WORDS + RING * ((1 + ENABLE) * CLEARED_CHANNELS + ENABLE * OUTPUTS)
"""When a sequence has ended or was aborted, or a client has disconnected; the amplitudes go to zero before."""
