"""The contracts between the daemon and whatever moves electrons, and how devices are found.

This room imports nothing else of the project.  Read `platform.py` for the whole, then one file per device contract:
`io_card.py`, `tx_rx_switch.py`, `power_amplifier.py`, `lna.py`.
"""
