"""The library: recordings, fits, simulated signals and diagnoses without a daemon; `platform_daemon` has its names.

recording.py   a recording of any kind: open, from_arrays
fit.py         a fit: values, covariance, table, picture
simulate.py    a ring-down with known truth
diagnosis.py   what a model lacks
"""
