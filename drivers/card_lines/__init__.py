"""Devices without a wire of their own: a Tx/Rx switch and an amplifier that hang on the I/O card's lines.

switch.py     a Tx/Rx switch that has nothing but the line RX_CONNECT, and perhaps a contact that reads back
amplifier.py  a plain power amplifier that one pin of the card enables
"""
