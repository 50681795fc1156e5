"""A USB device without a USB port: USB has no loopback wire, so it listens on a TCP port.

usb_server.py      the device's end of the port
usbtmc.py          the device's side of USBTMC and USB488
amplifier.py       the class-D amplifier's SCPI interpreter
frames.py          what travels over the socket, one frame per transfer
socket_backend.py  the host's end: a pyusb back end, which drivers find by entry point
descriptors.py     descriptors as pyusb expects them
"""
