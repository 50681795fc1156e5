"""Numbers that a calibration as a sensor is judged by, each with what sets it."""

COVERED = 0.8
"""Of the readings of a cross-validation that U of 95 % covers at least: of 15 the chance of fewer is 0.5 %."""
SIGNIFICANT = 0.01
"""Chance below which hysteresis, drift and an uncorrected temperature are lines of the budgets: of a hundred
calibrations without them one gets such a line."""

ALIKE_K = 1.0
"""In another unit the readings agree with the platform's thermometer to as much, rms: it is beside the resonator, and
of two thermometers in one room neither is off by more."""
UNLIKE = 10.0
"""Times as much they differ in the unit that is declared: a resonator in a warm chamber may be warmer than the
thermometer, but by just what a change of the unit makes of its temperature only by chance."""

AIR_PA = (5.5e4, 1.09e5)
"""Pressure of the air from 4800 m above the sea (standard atmosphere) to the highest that was ever seen (1085 hPa):
where nearly all readings lie in it in another unit, and none in theirs, the heading is wrong, or it is a vacuum or a
compressor, which `expected_from` and `expected_to` then say."""

FACTOR_WITHIN = 0.03
"""Rms of readings, over a power of ten, minus what an earlier calibration reads of the same frequencies, over the rms
of these: a sensor that drifts by more is none, and no drift is a factor of ten."""
FACTOR_FEWEST = 3
"""Shots that an earlier calibration reads before the factor is judged."""

BETTER = 3.0
"""Times less is left over with the reference shifted by whole hours.  A reference that is right leaves noise, which no
shift makes less; white noise of 20 pairs is never as uneven: of 400 right references of 20 to 200 pairs none is
refused, and of 256 that are off by 1 to 12 h all but 3, whose pressure changed slowly (`pytest -m long
tests/features/measurand -k zones`, with 800 draws in place of its 200)."""
ZONE_FEWEST, ZONE_SPAN = 20, 3.0
"""Pairs that a shift leaves, and the span of the shots in shifts: slow changes look alike over less."""
MOST_HOURS = 14
"""A local time is at most so far from UTC."""
