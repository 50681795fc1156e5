"""The routes, one file per subject; what all jobs have in common is api/job_routes.py.

acquisitions: Acquisitions as jobs: ask (202), watch, cancel.
alarms: What somebody should know, and numbers for those who watch many things.
self_tests: Self-tests as jobs: ask (202), watch, cancel.
calibrations: Calibrations as jobs: ask (202), watch, say that the dipole is turned, cancel.
catalogue: What can be measured and how: resonators and sequences that ship, those of the lab, and those added here.
derived: What follows from fits and plans: derived quantities, sliding windows, harmonics, predicted precision.
design: What a design says of a resonator, and what manufacturing defects do to it; computed at once, nothing moves.
characterisations: Characterisations of stored recordings as jobs.
diagnoses: Diagnoses of stored recordings as jobs.
events: What happens, as it happens: server-sent events with a journal behind them.
fits: Fits of stored recordings as jobs.
models: Adopted models: listed, shown with their evidence, retired, never deleted.
platform: What the platform is and does: state, readiness, the kinds of problems.
stop: Stop, and whether somebody is there: also all that the port for stop answers.
schedules: Work by the calendar, and what became of each start.
procedures: Procedures as jobs: ask (202), watch step by step, pause, resume, cancel.
recordings: Recordings on disk: list, describe, download, calibrated dm/dt for plots and in full.
specimens: What specimens do over months.
"""
