"""Names inside our recording files; docs/reference/file-format.md draws the tree.

The first block is fixed by the `.mmr` format and must stay; everything else is ours and belongs to `LAYOUT`.
"""

from __future__ import annotations

LAYOUT = "platform-daemon/1"
LAYOUT_ATTRIBUTE = "recording_layout"
"""Root attribute that says `LAYOUT`; a reader that knows another value reads the minimal table only."""

DATA = "/data"
SEQUENCE = "/sequence"
CALIBRATION = "/calibration"
SENSITIVITY = "/calibration/sensitivity"
FREQUENCY = "/calibration/frequency"
FREQUENCY_RESPONSE = "/calibration/frequency_response"
TRANSMIT = "/calibration/transmit"
INFLUENCES = "/calibration/uncertainty"
VARIANT = "/resonator/variant"

FRAMES = "/frames"
EXCITATION = "/excitation"
STEP = "/step"
STEP_VALUES = "/step/values"
ENTRY = "/entry"
CONFIGURATION = "/entry/configuration/data"
VALUE_SOURCES = "/entry/value_sources"
RING_DOWN = "/entry/ring_down"
FIT = "/fit"
SIMULATION = "/simulation"

FLAGS = ("overwritten", "corrupted", "lost_steps", "lna_overload", "amplifier_clipped")
"""Per-frame yes/no columns of `/frames`: the first three are the I/O card's own, see drivers/io_card.py."""

VARIANTS = ("thread", "jewel")
VERDICTS = ("good", "refused")
