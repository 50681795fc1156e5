"""The recordings with their splits: what a row may learn from, where its simulation starts, what is scored."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from tests.kit.data import DATA

MEASURED = DATA / "measured"
TRAIN = 0.7  # of a record, where there is one only
R4_UNTIL_S = 6.5  # it rests from 5.46 s on: what comes later has no spread to be measured by
START = 0.15  # of a record that is predicted from others


@dataclass(frozen=True)
class Record:
    """A ring-down. signal: (channels, n), rad or A m^2/s; rotation: (3, 3) and moment of dm/dt, told to the peers."""

    name: str
    time_s: Array
    signal: Array
    quantity: str = "angle"
    rotation: Array | None = None
    moment_am2: float = 0.0

    @property
    def rate_hz(self) -> float:
        return (self.time_s.size - 1) / float(self.time_s[-1] - self.time_s[0])

    def first(self, samples: int) -> Record:
        """Its beginning."""
        return Record(
            self.name, self.time_s[:samples], self.signal[:, :samples], self.quantity, self.rotation, self.moment_am2
        )


@dataclass(frozen=True)
class Task:
    """train: the coefficients come from these; scored: simulated at one go.

    start: samples of `scored` to which its start is fitted; all after them are scored. variant: as declared to the
    product; None: not named. declared: torques beside the sine. truth: hidden effects; None: nobody knows.
    """

    name: str
    train: tuple[Record, ...]
    scored: Record
    start: int
    variant: str | None = None
    declared: tuple[str, ...] = ("viscous_damping",)
    truth: tuple[str, ...] | None = None
    strengths: tuple[float, ...] = ()


def angle_record(path: Path) -> Record:
    """One of tests/data/measured."""
    with h5py.File(path) as file:
        return Record(path.stem, file["time"][:].astype(float), file["signal"][:].astype(float))


def split_in_time(name: str, record: Record, **known: object) -> Task:
    """The first 70 % teach, the rest is scored."""
    n = int(TRAIN * record.time_s.size)
    return Task(name, (record.first(n),), record, n, **known)  # type: ignore[arg-type]


def measured() -> dict[str, Task]:
    """r1, r2 (across runs), r4, and the two rods of r5."""
    runs = [angle_record(MEASURED / f"r2_rotary_pendulum_run{k}.h5") for k in (1, 2, 3)]
    n = int(START * runs[1].time_s.size)
    found = {
        "r1": split_in_time("r1", angle_record(MEASURED / "r1_single_pendulum_55s.h5")),
        "r2": Task("r2", (runs[0], runs[2]), runs[1], n),
    }
    for name, stem in (("r4", "r4_single_pendulum_end"), ("r5a", "r5_hung_rod_a"), ("r5b", "r5_hung_rod_b")):
        path = MEASURED / f"{stem}.h5"
        record = angle_record(path)
        if name == "r4":
            record = record.first(int(np.searchsorted(record.time_s, R4_UNTIL_S)))
        found[name] = split_in_time(name, record)
    return found


def write_angles(record: Record, path: Path) -> Path:
    """As the measured files are laid out."""
    with h5py.File(path, "w") as file:
        file["time"], file["signal"] = record.time_s, record.signal
        file.attrs["quantity"], file.attrs["units"] = "angle", "rad"
    return path


def write_dmdt(record: Record, path: Path, variant: str) -> Path:
    """One shot in the minimal layout; its sensitivity is the unit matrix, so that volts are dm/dt."""
    decimation = 2048
    with h5py.File(path, "w") as file:
        file["data"] = record.signal[None].astype(np.float32)
        file["calibration/sensitivity"] = np.eye(3)
        file["resonator/variant"] = variant
        file["sequence/baseFrequency"] = record.rate_hz * decimation
        file["sequence/decimation"] = decimation
        file["sequence/numTxSamples"], file["sequence/numSwitchSamples"] = 0, 0
        file["sequence/numRxSamples"] = record.time_s.size
    return path
