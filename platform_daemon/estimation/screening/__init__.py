"""What the samples alone tell, before any model: frequency, periods, saturation, windows.

angle_cycles: Swings of an angle record: its frequency, its passages through zero and its turning points, from the
    samples alone.
angle_motion: Angle records in which nothing swings, too little does, or nothing dies away.
beat: Two resonators that no fit got through: seen in the fundamental itself, without any model of the motion.
clipping: Clipping, seen in the samples as the converter gave them.
crest: How far the peaks of a waveform stand above its root mean square.
frequency_search: Block means, and the frequency that explains most of a short stretch of them, with which start
    values begin.
fundamental: Where the oscillation of a ring-down is in its spectrum.
oscillation: Where the oscillation of a record is, whatever the record reads.
periods: How many periods a short record holds: a spectrum of so few has no lines.
screening: Records that cannot be fitted are refused before any start value is sought.
separate_lines: Two resonators far from each other: two lines in the spectrum, of which none is a harmonic of the
    other.
spectral_lines: What all searches for lines in a spectrum share: the spectrum, the level beside a line, its place,
    whose it may be.
two_resonators: Two resonators in one record, near each other or far, named without any model of the motion.
windows: Which samples a fit uses: the paper's N50 and D30 datasets, or any number of seconds.
"""
