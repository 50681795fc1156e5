"""The lab's devices as they look from their wires, all attached to one simulated world.

emulator.py     a whole lab: the world, and whatever listens for it; read this first
options.py      its options: the TOML file
control.py      a door into the world for tests
io_card/        RedPitayaDAQServer and the cards behind it
serial/         Tx/Rx switch and LNA on pseudo-terminals
usb/            the amplifier, USBTMC over a TCP port
scpi.py         headers of SCPI commands, long, short and numbered
listening.py    a TCP port with one thread per connection
wire_faults.py  things that go wrong between a device and its driver, on purpose
"""
