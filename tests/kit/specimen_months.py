"""Recordings of one specimen over months, with on-line fits and little else in them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

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
    """One every six hours, of one shot; after DROP_AT of them m_r is 0.5 % and f_nat 0.25 % lower."""
    rng = np.random.default_rng(seed)
    made = []
    for k in range(recordings):
        warm = 21.0 + np.sin(0.5 * np.pi * k) + rng.normal(0.0, 0.2)
        lost = 0.005 * (k >= DROP_AT)
        f_nat = 213.0 * (1.0 - 5e-4 * (warm - 21.0) - lost / 2 + rng.normal(0.0, 2e-5))
        m_r = 0.012 * (1.0 - 1e-3 * (warm - 21.0) - lost + rng.normal(0.0, 2e-4))
        at = (begun + timedelta(hours=6 * k)).isoformat()
        table = replace(
            fit_table(1), values=np.array([[f_nat, m_r]]), std=np.array([[1e-3, 1e-6]]), verdict=("good",),
            reason=("",), nrmse=np.array([0.01 * (1.0 + rng.normal(0.0, 0.01))]),
        )  # fmt: skip
        path = folder / f"{re.sub(r'[ /]', '-', specimen)}-{k:03d}.h5"
        with SeriesWriter.create(
            path, header(start_time=at, sample_name=specimen, comment=comment, planned_shots=1, clock=clock)
        ) as writer:
            writer.add_shot(replace(shot(k % 50 + 1), time_stamp=at, temperature_c=warm))
            writer.finish((table,))
        made.append(path)
    return made


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
