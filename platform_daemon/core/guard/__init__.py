"""The process that switches all outputs off when the owner of the hardware dies or hangs."""
