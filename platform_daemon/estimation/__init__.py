"""From calibrated dm/dt, volts or an angle to a `FitResult`; no files, no devices, no web."""
