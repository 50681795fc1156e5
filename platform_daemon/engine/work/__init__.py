"""What a job does, with the hardware or with files; each keeps the protocol `Work` of engine/jobs.py.

calibration: Calibrations as jobs: a known dipole for the receive side, a field probe for the transmit side.
calibration_bench: What the calibrations share: the bench that their shots are made on.
receive_calibration: Calibration of the receive side as a job: a known dipole in the resonator's place gives P by
    frequency.
characterisation: A characterisation of a stored recording as a job.
destination: Where the shots of a series go: to a file of its own, or into the one recording of a procedure.
diagnosis: A diagnosis of stored recordings as a job; report and page are kept on disk.
fit: A fit of a stored recording as a job; the report is kept on disk.
reset_fault: After a trip: the amplifier's latched fault is cleared by a command of its own, never by the way.
self_test: The self-test before a series: a low tone per coil, heard through the leakage of the open receive
    contacts.
self_test_work: The self-test as a job of its own.
series: A series of shots: each is on disk before it counts, fits run beside, and what was made is kept whatever
    happens.
series_fits: The on-line fits of a series, from the stored files of its shots.
series_records: A series and its shots as the store keeps them.
shots_in_turn: The shots of a series one after the other: what each is to be, and the next drive from the last fit.
storing: Shots on their way to the disk: in order, and a few at once, so that a slow disk makes no shot late.
transmit_calibration: Calibration of the transmit side as a job: a field probe in the rotor's place gives the field
    per volt of a coil.
"""
