"""Red Pitaya STEMlab 125-14 running RedPitayaDAQServer, one card or several with a common trigger.

card.py         the I/O card contract over all boards: life cycle, reading, stopping
abilities.py    what it can do
trigger.py      common start and stop of the boards
boards.py       what is done to all boards
replay.py       a board whose memory keeps a shot, to be played again without an upload
watchdog.py     its watchdog: the wire, the counter, and the questions before each shot
watchdog_proof.py   each card's watchdog acts, seen at the start
emergency.py    the input that switches the outputs off
board.py        one board: who it is, its registers, its sequence
registers.py    its registers that survive a reconnect, as commands
sequence.py     timeline -> step sequence, enable bits and sines of each board
layout.py       which terminal of which board is which input, output and line of the platform
lines.py        lines on pins that no sequence can time: set by command, late, and checked how late
haste.py        how long it is waited for while power may be on
gate_clock.py   the end of a gate by command, by the clock, should no sample tell it
pins.py         a pin set by command and read back at the pad
scale.py        what its memory says of its converters
reader.py       the boards' streams as one recording
stream.py       samples and status records of a pipelined read
sines.py        sines as commands, and their amplitudes read back
silence.py      outputs at zero, as commands, and read back
pairing.py      getting through to the server, whoever is in the way, and proving that both sockets are ours
connection.py   the two sockets: asking, uploading, receiving
ports.py        connecting to one port
commands.py     every command the driver may send, and what the server answers to it
lock.py         one daemon per card on this computer
backend.py, options.py   the back end `red_pitaya` and its tables
"""
