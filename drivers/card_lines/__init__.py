"""Devices without a wire of their own: a Tx/Rx switch and an amplifier that hang on the I/O card's lines."""
