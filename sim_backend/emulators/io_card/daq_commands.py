"""The command table of the I/O card's server: who answers which header.

Handlers run with the world's lock held, except those that wait.
"""

from __future__ import annotations

from ..scpi import CommandTable
from .daq_acquisition import ACQUISITION
from .daq_calibration import CALIBRATION
from .daq_handler import Handler
from .daq_misc import SERVER
from .daq_sequence import SEQUENCE, UPLOADS, set_sequence
from .daq_waveforms import WAVEFORMS, set_table

COMMANDS: CommandTable[Handler] = CommandTable(SERVER | WAVEFORMS | SEQUENCE | ACQUISITION | CALIBRATION)

WAITING = frozenset({set_table, set_sequence, *UPLOADS})
"""Handlers that wait for bytes or take their time; they take the world's lock themselves if they need it."""
