"""Pressure sensors whose truth is known, and readings of a barometer beside them."""

from __future__ import annotations

import math
from datetime import UTC, datetime

import h5py
import numpy as np

from drivers.specimen import Measurand
from platform_daemon.features.measurand.reference_file import Reference
from platform_daemon.features.measurand.shots import Shots

PRESSURE = Measurand(
    name="pressure",
    unit="mbar",
    degree=2,
    corrected_for="temperature",
    reference={"u": 0.05, "source": "certificate of the barometer"},
)
DAY_S, START_S = 86400.0, datetime(2026, 3, 1, tzinfo=UTC).timestamp()
SCATTER_HZ, BAROMETER_MBAR = 0.02, 0.1


class PressureSensor:
    """The truth of a pressure sensor: f of pressure and temperature, and how both go."""

    def __init__(self, seed):
        self.random = np.random.default_rng(seed)
        self.phases = self.random.uniform(0.0, 2.0 * np.pi, 4)
        self.barometer_mbar = 0.05 * self.random.standard_normal()  # what all readings of the reference have in common

    def at(self, times_s):
        hours = (times_s - START_S) / 3600.0
        mbar = 1000.0 + 25.0 * np.sin(hours / 9.0 + self.phases[0]) + 10.0 * np.sin(hours / 2.0 + self.phases[1])
        celsius = 22.0 + 3.0 * np.sin(hours / 5.0 + self.phases[2]) + np.sin(hours / 1.3 + self.phases[3])
        return mbar, celsius

    def f_hz(self, mbar, celsius):
        d = mbar - 1000.0
        return 213.0 - 0.06 * d + 1e-4 * d**2 - 0.23 * (celsius - 22.0)

    def shots(self, begin_s, count, step_s):
        times = begin_s + step_s * np.arange(count)
        mbar, celsius = self.at(times)
        f = self.f_hz(mbar, celsius) + SCATTER_HZ * self.random.standard_normal(count)
        shots = Shots(
            frames=tuple(range(count)),
            times_s=times,
            f_hz=f,
            std_hz=np.full(count, 1e-4),
            celsius=celsius + 0.01 * self.random.standard_normal(count),
            refused=(),
        )
        return shots, mbar

    def reference(self, begin_s, end_s, step_s=60.0):
        times = np.arange(begin_s - 600.0, end_s + 600.0, step_s)
        noise = BAROMETER_MBAR * self.random.standard_normal(len(times))
        return Reference(times, self.at(times)[0] + self.barometer_mbar + noise, np.full(len(times), BAROMETER_MBAR))


def pressures(file):
    """Of the housing of the simulated resonator, mbar, for each shot of a recording."""
    with h5py.File(file) as h5:
        return h5["simulation/values/simulated.pressure_mbar"][:]


def barometer(file, period_s):
    """A file of a reference: what a barometer reads every 5 s while a recording is made, as the truth of its shots,
    a sine of that period, says; with noise."""
    with h5py.File(file) as h5:
        stamps = [stamp.decode() for stamp in h5["frames/time_stamp"][:]]
    times = np.array([datetime.fromisoformat(stamp).timestamp() for stamp in stamps])
    dense = np.arange(times[0] - 20.0, times[-1] + 20.0, 5.0)

    def columns(at):
        phase = 2.0 * math.pi / period_s * (at - times[0])
        return np.column_stack([np.ones(len(at)), np.sin(phase), np.cos(phase)])

    mbar = columns(dense) @ np.linalg.lstsq(columns(times), pressures(file), rcond=None)[0]
    mbar += BAROMETER_MBAR * np.random.default_rng(0).standard_normal(len(dense))
    rows = [f"{datetime.fromtimestamp(t, UTC).isoformat()},{x:.4f},0.1" for t, x in zip(dense, mbar, strict=True)]
    return "\n".join(["time,pressure [mbar],u [mbar]", *rows])
