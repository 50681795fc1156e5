"""Red Pitaya STEMlab 125-14 running RedPitayaDAQServer, one card or several with a common trigger.

card.py         the I/O card contract over all boards: life cycle, reading, stopping
capabilities.py    its capabilities, from its table and its EEPROM
trigger.py      common start and stop of the boards
boards.py       what is done to all boards
emergency.py    the input that switches the outputs off
board.py        one board: its identity, its registers, its sequence
sequence.py     timeline -> step sequence, enable bits and sines of each board
layout.py       which terminal of which board is which input, output and line of the platform
lines.py        lines on pins that no sequence can time: set by command, late, and checked how late
reply_deadline.py  how long to wait for answers while power may be on
gate_clock.py   lowers a gate that is set by command when no sample has reported its end
pins.py         a pin set by command and read back at the pad
scale.py        what its memory says of its converters
reader.py       the boards' streams as one recording
stream.py       samples and status records of a pipelined read
sines.py        sines as commands, and their amplitudes read back
output_readback.py outputs at zero, as commands, and read back
pairing.py      connects to the server past other clients, and proves that both sockets belong to one client
connection.py   the two sockets: asking, uploading, receiving
ports.py        connecting to one port
commands.py     every command that the driver may send, its reply, and the commands that set all registers
lock.py         one daemon per card on this computer
backend.py, options.py   the back end `red_pitaya` and its tables
"""
