"""Files for diagnoses: the examples and measured pendulums, whole, cut or damaged."""

import shutil

import h5py
import numpy as np

from tests.kit.data import DATA

THREAD, JEWEL = DATA / "example_thread.mmr.h5", DATA / "example_jewel.mmr.h5"
PENDULUM = DATA / "measured" / "r1_single_pendulum_55s.h5"
RUNS = tuple(DATA / "measured" / f"r2_rotary_pendulum_run{k}.h5" for k in (1, 2, 3))


def copied(folder, source=THREAD, name="copy.h5"):
    """A copy that may be changed."""
    target = folder / name
    shutil.copyfile(source, target)
    return target


def without(folder, path, source=THREAD):
    """A copy without one HDF5 object."""
    target = copied(folder, source)
    with h5py.File(target, "r+") as file:
        del file[path]
    return target


def first_frames(folder, count, name="few.h5"):
    """The first frames of the thread example."""
    target = copied(folder, THREAD, name)
    with h5py.File(target, "r+") as file:
        data, units = file["data"][:count], dict(file["data"].attrs)
        del file["data"]
        file.create_dataset("data", data=data)
        file["data"].attrs.update(units)
    return target


def pendulum(folder, time_s, angle_rad, name="angle.h5", units="rad"):
    """An angle file."""
    target = folder / name
    with h5py.File(target, "w") as file:
        file["time"] = time_s
        file["signal"] = np.atleast_2d(angle_rad)
        file["signal"].attrs["units"] = units
    return target


def swing(seconds=12.0, rate_hz=400.0, noise=1e-3, seed=1, f_hz=2.0, decay_per_s=0.15, start_rad=0.4):
    """(time, angle) of a slowly decaying small swing with white noise."""
    t = np.arange(int(seconds * rate_hz)) / rate_hz
    angle = start_rad * np.exp(-decay_per_s * t) * np.cos(2 * np.pi * f_hz * t + 0.3)
    return t, angle + np.random.default_rng(seed).normal(0.0, noise, t.size)
