"""I/O cards behind RedPitayaDAQServer, as their clients meet them.

The protocol:

daq_server.py       a command port, a data port, one client at a time
scpi_session.py     one client: reads commands, answers them, sends samples in between
sending.py          a read of samples in progress: chunks and their records
daq_handler.py      what its handlers share: arguments, replies, what they need of the server
daq_acquisition.py  decimation, trigger, reading
daq_waveforms.py    waveforms, offsets, tables, ramps
daq_sequence.py     the sequence and its uploads
daq_calibration.py  what the EEPROM holds
daq_misc.py         the server itself, pins, registers that only stay where they are

The cards:

options.py    the table `[io_cards]`
registers.py  registers of the outputs
memory.py     how often the server touches its sequence memory
sequence.py   uploads, SEQ:SET with its traps, and the program that runs from the trigger on
playback.py   what the registers make the outputs and lines do
sample_ring.py what the converters recorded
shot.py       the shot that all cards play and record together
board.py      one card: modes, trigger, write pointer, samples
session.py    all cards of a lab, and which of them have the trigger
"""
