"""The hardware process: one shot, the interlock, the hardware thread, read-back and settling."""
