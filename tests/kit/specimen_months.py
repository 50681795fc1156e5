"""Recordings of one specimen over months, with on-line fits and little else in them."""

from __future__ import annotations

import re
import shutil
import uuid
from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import h5py
import numpy as np

from platform_daemon.core.recordings.recording import StepLabel
from platform_daemon.core.recordings.series_writer import SeriesWriter
from platform_daemon.core.schemas.base import ClockKind
from tests.kit.recording_files import fit_table, header, shot

DROP_AT = 50


def months(
    folder: Path,
    recordings: int = 70,
    specimen: str = "T 1",
    seed: int = 1,
    comment: str = "",
    begun: datetime = datetime(2026, 3, 1, tzinfo=UTC),
    clock: ClockKind | None = None,
) -> list[Path]:
    """One every six hours, of one shot; after DROP_AT of them m_r is 0.5 % and f_nat 0.25 % lower.

    The first one is written as the daemon does; the others are copies with their own times, temperature and fit, which
    takes a tenth of the time.
    """
    rng = np.random.default_rng(seed)
    made: list[Path] = []
    for k in range(recordings):
        warm = 21.0 + np.sin(0.5 * np.pi * k) + rng.normal(0.0, 0.2)
        lost = 0.005 * (k >= DROP_AT)
        f_nat = 213.0 * (1.0 - 5e-4 * (warm - 21.0) - lost / 2 + rng.normal(0.0, 2e-5))
        m_r = 0.012 * (1.0 - 1e-3 * (warm - 21.0) - lost + rng.normal(0.0, 2e-4))
        nrmse = 0.01 * (1.0 + rng.normal(0.0, 0.01))
        path = folder / f"{re.sub(r'[ /]', '-', specimen)}-{k:03d}.h5"
        if not made:
            table = replace(fit_table(1), std=np.array([[1e-3, 1e-6]]), verdict=("good",), reason=("",))
            about = header(sample_name=specimen, comment=comment, planned_shots=1, clock=clock)
            with SeriesWriter.create(path, about) as writer:
                writer.add_shot(shot(1))
                writer.finish((table,))
        else:
            shutil.copy(made[0], path)
        _change(path, begun + timedelta(hours=6 * k), warm, (f_nat, m_r), nrmse)
        made.append(path)
    return made


def _change(path: Path, at: datetime, celsius: float, fitted: tuple[float, float], nrmse: float) -> None:
    with h5py.File(path, "r+") as h5:
        stamp = at.isoformat()
        h5["entry/entry_identifier"][()] = uuid.uuid4().hex
        h5["entry/start_time"][()] = h5["entry/end_time"][()] = stamp
        h5["frames/time_stamp"][0] = stamp
        h5["frames/temperature"][0] = celsius
        (fit,) = h5["fit"].values()
        fit["values"][0] = fitted
        fit["nrmse"][0] = nrmse


def procedure(folder: Path, name: str, labels: Sequence[StepLabel], f_nat_hz: Sequence[float]) -> None:
    """A recording of a procedure with the specimen T 1: a shot per step with its fit."""
    table = replace(
        fit_table(len(labels)), values=np.array([[f, 0.012] for f in f_nat_hz]), verdict=("good",) * len(labels),
        std=np.full((len(labels), 2), 1e-3), reason=("",) * len(labels), nrmse=np.full(len(labels), 0.01),
    )  # fmt: skip
    about = header(title="T, characterise", sample_name="T 1", planned_shots=len(labels))
    with SeriesWriter.create(folder / f"{name}.h5", about) as writer:
        for k, label in enumerate(labels):
            writer.add_shot(replace(shot(k + 1), step=label))
        writer.finish((table,))
