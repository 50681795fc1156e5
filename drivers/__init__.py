"""The contracts between the daemon and whatever moves electrons, and how devices are found.

This room imports nothing else of the project.  What a device promises, one file each:

io_card.py          plays a timeline on outputs and lines, records its inputs on the same clock, stops from any thread
tx_rx_switch.py     connects the coils to the amplifier or to the receiver, never to both
power_amplifier.py  enabled, muted, faulty: whether it can put out power, and how to take that away
lna.py              a low-noise amplifier with a gain and an overload
thermometer.py      a temperature near the resonator
reference.py        what calibrates the platform: a reference dipole, a field probe
power_guard.py      whoever switches outputs off for an owner that died or hangs
clock.py            monotonic time, time of day and sleep, which a simulation may speed up
urgency.py          the thread that moves the shot goes before other programs, where the computer lets it

What crosses the contracts:

timeline.py     the sample-exact shot that an I/O card plays: bursts of sines, levels of digital lines, windows
calibration.py  what a platform's channels mean in the units of physics: receive and transmit side
specimen.py     a resonator as its TOML file declares it
identity.py     what a device says of itself
errors.py       the exception tree of the project

How a platform comes about:

platform.py      `Platform`, all devices of a lab, and `Backend`, which makes them
backend.py       `RealBackend`, the beginning of a back end in real time
registry.py      finds back ends by entry point and builds a platform from its tables
wiring_proof.py  a line that some cards cannot drive does move the switch
entry_points.py  what other packages publish for us, by group and name
validation.py    an option table checked by its pydantic model, as one ConfigError
outputs_off.py   switches the outputs of a platform off from its tables alone
inventory.py     identity and state of each device of a platform, whatever fails

Back ends: `declared.py` (numbers in the platform file), `red_pitaya/`, `serial_line/`, `scpi/`; `card_lines/` holds
devices on the lines of an I/O card.  For their authors: `exchange.py` asks over any wire that carries lines,
`contacts.py` waits for contacts that move, `testing.py` scripts a wire, `conformance/` are the contracts as tests
(`contract.py` is their old name).
"""
