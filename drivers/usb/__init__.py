"""USB without a USB port: `socket_backend` joins pyusb to a device that listens on a TCP socket."""
