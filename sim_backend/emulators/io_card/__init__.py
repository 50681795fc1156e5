"""I/O cards behind RedPitayaDAQServer, as their clients meet them.

The conversation:

daq_server.py       a command port, a data port, one client at a time
conversation.py     one client: reads commands, answers them, sends samples in between
sending.py          a read of samples in progress: chunks and their records
daq_commands.py     the command table
daq_handler.py      what its handlers share: arguments, replies, what they need of the server
daq_acquisition.py  decimation, trigger, reading
daq_waveforms.py    waveforms, offsets, tables, ramps
daq_sequence.py     the sequence and its uploads
daq_calibration.py  what the EEPROM holds
daq_misc.py         the server itself, pins, registers that only stay where they are

The cards:

options.py    the table `[io_cards]`
registers.py  what the outputs are told
memory.py     how often the server touches its sequence memory
emergency.py  the emergency input, the counter on three pins, and a wire between them
sequence.py   uploads, SEQ:SET with its traps, and the program that runs from the trigger on
waveforms.py  periodic waveforms as sums of sines
playback.py   what the registers make the outputs and lines do
converters.py what filters and converters make of the volts at the inputs
tape.py       what the converters recorded
shot.py       the shot that all cards play and record together
board.py      one card: modes, trigger, write pointer, samples
session.py    all cards of a lab: who has the trigger
"""
