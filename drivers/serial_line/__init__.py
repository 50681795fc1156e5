"""Devices on a serial line: Tx/Rx switch and LNA, as docs/wire-protocols.md describes them."""
