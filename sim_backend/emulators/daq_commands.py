"""The command table of the I/O card's server: who answers which header.

Handlers run with the world's lock held, except those that wait for an upload.
"""

from __future__ import annotations

from sim_backend.emulators.daq_acquisition import ACQUISITION
from sim_backend.emulators.daq_calibration import CALIBRATION
from sim_backend.emulators.daq_handler import Handler
from sim_backend.emulators.daq_misc import SERVER
from sim_backend.emulators.daq_sequence import SEQUENCE, UPLOADS
from sim_backend.emulators.daq_waveforms import WAVEFORMS, set_table
from sim_backend.emulators.scpi import CommandTable

COMMANDS: CommandTable[Handler] = CommandTable(SERVER | WAVEFORMS | SEQUENCE | ACQUISITION | CALIBRATION)

WAITING = frozenset({set_table, *UPLOADS})
"""Handlers that wait for bytes on the data socket, and take the world's lock themselves if they need it."""
