"""The contracts between the daemon and its devices, and how devices are found.

This package imports nothing else of the project.  The contract of each device is one file:

io_card.py          plays a timeline on outputs and lines, records its inputs on the same clock, stops from any thread
tx_rx_switch.py     connects the coils to the amplifier or to the receiver, never to both
power_amplifier.py  enabled, muted, faulty: whether it can put out power, and how to take that away
lna.py              a low-noise amplifier with a gain and an overload
thermometer.py      a temperature near the resonator
claims.py           one process of the computer at a time holds a name, such as that of a card
reference.py        what calibrates the platform: a reference dipole, a field probe
power_guard.py      the guard that switches outputs off when their owner has died or hangs
clock.py            monotonic time, time of day and sleep, which a simulation may speed up
realtime.py         real-time priority for the thread that runs a shot, where the operating system permits it

What crosses the contracts:

timeline.py     the sample-exact shot that an I/O card plays: bursts of sines, levels of digital lines, windows
calibration.py  the channels of a platform in physical units: receive and transmit side
specimen.py     a resonator as its TOML file declares it
uncertainty.py  how well influences on a result are known, as platform and resonator files declare it
identity.py     manufacturer, model, serial number and firmware of a device
errors.py       the exception tree of the project

How a platform is built:

platform.py      `Platform`, all devices of a lab, and `Backend`, which makes them
backend.py       `RealBackend`, the base class of back ends of real devices
registry.py      finds back ends by entry point and builds a platform from its tables
wiring_proof.py  proves that the receiver's line moves the switch
entry_points.py  loads what other packages publish, by group and name
validation.py    an option table checked by its pydantic model, as one ConfigError
text_files.py    reads text files of any editor, with or without a byte order mark
outputs_off.py   switches the outputs of a platform off from its tables alone
inventory.py     identity and state of each device of a platform

Back ends: `declared.py` (numbers in the platform file), `red_pitaya/`, `serial_line/`, `scpi/`; `card_lines/` holds
devices that are driven by the lines of an I/O card.  For their authors: `exchange.py` queries over any wire,
`relay.py` waits until contacts have settled, `testing.py` scripts a wire, `conformance/` holds the contracts as tests.
"""
